# SPDX-License-Identifier: Apache-2.0
"""Tests of `./reve export` with programs of others: the reader of the MCAP project, and the message
types of Foxglove."""

import csv
import datetime
import importlib
import importlib.util
import json
import pathlib
import subprocess
import tempfile
import unittest

import pytest
from support import PACKAGE

ROOT = PACKAGE.parents[1]
PACKAGES = ("mcap", "google.protobuf", "foxglove_schemas_protobuf")

WORLD = """
reve: 1
name: shapes
prototype: si-f64
laws: [gravity_field, hooke_spring, newton_motion, angular_motion]
constants: {gravity: [0, -9.81, 0]}
items:
  - {name: ball, physical: {shape: sphere, radius: 0.5, location: [0, 5, 0], colour: "#ff8000"},
     physics: {mass: 2 kg, velocity: [1, 0, 0.5]}}
  - {name: crate, physical: {shape: box, size: [1, 2, 3], location: [3, 5, 0]},
     physics: {mass: 1 kg, inertia: [1, 2, 3], angularVelocity: [0.3, 2, 0.1]}}
  - {name: pill, physical: {shape: capsule, radius: 0.25, height: 2, location: [-3, 5, 0]},
     physics: {mass: 1 kg}}
  - {name: egg, physical: {shape: ellipsoid, size: [0.5, 1, 2], location: [-6, 5, 0]}}
  - {name: tin, physical: {shape: cylinder, radius: 0.5, height: 1, location: [0, 5, 4]}}
  - {name: z-up, physical: {shape: plane, size: [20, 20], location: [0, 0, 0]}}
  - {name: tent, physical: {shape: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
     triangles: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], location: [6, 1, 6]}}
  - {name: rope, kind: spring, physics: {end1: ball, end2: crate, springConstant: 50 N/m, length: 2}}
  - {name: cord, kind: spring, physical: {colour: "#336699", width: 5 cm},
     physics: {end1: crate, end2: pill, length: 2}}
  - {name: lost, kind: spring, physical: {colour: "#33669900"},
     physics: {end1: crate, end2: pill, length: 2}}
  - {name: sail, kind: surface, physics: {vertices: [ball, crate, pill], hardness: 0}}
"""


def installed(package):
    try:
        return importlib.util.find_spec(package) is not None
    except ModuleNotFoundError:
        return False


def reve(*arguments):
    run = subprocess.run(
        [str(ROOT / "reve"), *map(str, arguments)], cwd=ROOT, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


def nanos(time):
    return time["sec"] * 10**9 + time["nsec"]


@pytest.mark.slow
@unittest.skipUnless(all(map(installed, PACKAGES)), f"{PACKAGES} are not installed")
class McapTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        (cls.folder / "world.yaml").write_text(WORLD)
        log = cls.folder / "run.log"
        cls.mcap = cls.folder / "run.mcap"
        reve("run", cls.folder, "--seconds", "3", "--record", log)
        pictures = ("--pictures", 1, "--world", cls.folder, "--size", "160x120")
        reve("export", log, "--mcap", cls.mcap, "--csv", cls.folder / "csv", *pictures)

    def messages(self, *topics, **limits):
        from mcap.reader import make_reader

        with self.mcap.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            for _, channel, message in reader.iter_messages(topics=topics or None, **limits):
                yield channel.topic, message, json.loads(message.data)

    def table(self, kind):
        with (self.folder / f"csv/{kind}.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    def test_the_summary_and_the_chunks_agree(self):
        from mcap.reader import NonSeekingReader, make_reader

        with self.mcap.open("rb") as file:
            statistics = make_reader(file, validate_crcs=True).get_summary().statistics
            file.seek(0)
            in_order = [
                (channel.topic, message.log_time, message.data)
                for _, channel, message in NonSeekingReader(
                    file, validate_crcs=True
                ).iter_messages()
            ]
        by_index = [(topic, m.log_time, m.data) for topic, m, _ in self.messages()]
        self.assertEqual(sorted(in_order), sorted(by_index))
        self.assertEqual(len(in_order), statistics.message_count)
        self.assertGreater(statistics.chunk_count, 1)
        self.assertEqual(statistics.message_end_time, 3 * 10**9)
        self.assertEqual(sum(statistics.channel_message_counts.values()), len(in_order))

    def test_all_poses_are_those_of_the_replayed_states(self):
        rows = iter(self.table("body"))
        frames = 0
        for _, message, data in self.messages("/tf"):
            transforms = {each["child_frame_id"]: each for each in data["transforms"]}
            self.assertEqual(transforms.pop("world")["parent_frame_id"], "z-up")
            for each in transforms.values():
                row = next(rows)
                self.assertEqual(message.log_time, int(row["frame"]) * 10**9 // 60)
                self.assertEqual(nanos(each["timestamp"]), message.log_time)
                self.assertEqual(each["child_frame_id"].removeprefix("body "), row["item"])
                self.assertEqual(each["parent_frame_id"], "world")
                for axis in "xyz":
                    there = float(row[f"position.{axis} [m]"])
                    self.assertEqual(each["translation"][axis], there)
                for axis in "xyzw":
                    turned = float(row[f"orientation.{axis} [1]"])
                    self.assertEqual(each["rotation"][axis], turned)
            frames += 1
        self.assertEqual(frames, 181)
        self.assertIsNone(next(rows, None))

    def test_a_free_body_falls_as_the_closed_form_says(self):
        fall = [
            (data["time"], {each["name"]: each for each in data["items"]}["pill"])
            for _, _, data in self.messages("/properties/body")
        ]
        for time, pill in fall:
            # The law newton_motion changes the velocity before the position, so a body falls g dt^2
            # n (n + 1) / 2 in n steps.
            drop = 9.81 * time * (time + 1 / 60) / 2
            self.assertAlmostEqual(pill["position"]["y"], 5 - drop, 9)
            self.assertAlmostEqual(pill["velocity"]["y"], -9.81 * time, 9)

    def test_the_index_finds_the_messages_of_a_time(self):
        found = [
            m.log_time
            for _, m, _ in self.messages("/tf", starting_at=10**9, ending_before=2 * 10**9)
        ]
        self.assertEqual(len(found), 60)
        self.assertEqual(min(found), 10**9)

    def test_the_messages_are_those_of_foxglove(self):
        from google.protobuf import json_format

        types = {"/tf": "FrameTransforms", "/scene": "SceneUpdate", "/connections": "SceneUpdate"}
        seen = {}
        for topic, _, data in self.messages(*types):
            module = importlib.import_module(f"foxglove_schemas_protobuf.{types[topic]}_pb2")
            # The conversion raises an error for an unknown field, or a field of another type.
            seen[topic] = json_format.ParseDict(for_protobuf(data), getattr(module, types[topic])())
        shapes = {entity.id: entity for entity in seen["/scene"].entities}
        self.assertEqual(set(shapes), {"ball", "crate", "pill", "egg", "tin", "z-up", "tent"})
        self.assertEqual(shapes["z-up"].frame_id, "body z-up")
        self.assertAlmostEqual(shapes["ball"].spheres[0].color.g, 128 / 255)
        self.assertEqual(shapes["crate"].cubes[0].size.z, 3)
        self.assertEqual(shapes["egg"].spheres[0].size.y, 1)
        self.assertEqual([len(shapes["pill"].spheres), len(shapes["pill"].cylinders)], [2, 1])
        self.assertEqual(shapes["pill"].cylinders[0].size.z, 1.5)
        self.assertEqual(len(shapes["tent"].triangles[0].points), 12)
        connections = seen["/connections"].entities[0]
        self.assertEqual([len(lines.points) for lines in connections.lines], [2, 2])
        cord = connections.lines[1]
        self.assertEqual([cord.thickness, cord.scale_invariant], [0.05, False])
        self.assertAlmostEqual(cord.colors[0].r, 0x33 / 255)
        last = {row["item"]: row for row in self.table("body")[-7:]}
        for point, item in zip(connections.triangles[0].points, ("ball", "crate", "pill")):
            self.assertEqual(point.x, float(last[item]["position.x [m]"]))

    def test_the_pictures_are_those_of_snapshot(self):
        from foxglove_schemas_protobuf import CompressedImage_pb2
        from google.protobuf import json_format

        times = []
        for _, message, data in self.messages("/picture"):
            picture = json_format.ParseDict(
                for_protobuf(data), CompressedImage_pb2.CompressedImage()
            )
            self.assertEqual(picture.format, "png")
            times.append(message.log_time // 10**9)
            taken = self.folder / "taken.png"
            reve(*f"picture {self.folder} --at {times[-1]} --size 160x120 --out {taken}".split())
            self.assertEqual(picture.data, taken.read_bytes())
        self.assertEqual(times, [0, 1, 2, 3])

    def test_the_schemas_describe_every_field(self):
        from mcap.reader import make_reader

        with self.mcap.open("rb") as file:
            for schema, channel, message in make_reader(file).iter_messages():
                self.assertEqual(schema.encoding, "jsonschema")
                require(self, json.loads(schema.data), json.loads(message.data), channel.topic)


def for_protobuf(data, name=""):
    """Returns the message with each time, {sec, nsec}, in the form of protobuf's JSON."""
    if isinstance(data, list):
        return [for_protobuf(each) for each in data]
    if not isinstance(data, dict):
        return data
    if set(data) != {"sec", "nsec"}:
        return {key: for_protobuf(value, key) for key, value in data.items()}
    if name == "lifetime":
        return f"{data['sec']}.{data['nsec']:09d}s"
    moment = datetime.datetime.fromtimestamp(data["sec"], datetime.timezone.utc)
    return f"{moment:%Y-%m-%dT%H:%M:%S}.{data['nsec']:09d}Z"


def require(test, schema, value, place):
    """Fails if a value has a field that its schema lacks, or another type."""
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool}
    kind = kinds.get(schema["type"], (int, float))
    test.assertIsInstance(value, kind, place)
    if isinstance(value, dict):
        for name, field in value.items():
            test.assertIn(name, schema["properties"], place)
            require(test, schema["properties"][name], field, f"{place}.{name}")
    if isinstance(value, list):
        for each in value:
            require(test, schema["items"], each, place)
