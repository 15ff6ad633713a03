# SPDX-License-Identifier: Apache-2.0
"""Compares pictures of `./reve picture` with those of an independent renderer, MuJoCo's.

Both draw the same spheres and boxes from the same viewpoint, with OSMesa. The outline of each item
and the depths inside it must agree. Skipped if the packages mujoco and numpy are not installed.
"""

import importlib.util
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from support import PACKAGE

ROOT = PACKAGE.parents[1]
WIDTH, HEIGHT = 480, 320
FOV = 40  # vertical angle of view [deg]
EYE, TARGET = (3.0, 4.0, 9.0), (0.2, 0.6, -0.3)  # [m]
MISSING = [name for name in ("mujoco", "numpy") if importlib.util.find_spec(name) is None]

# Differences of depths that the tessellation of spheres, and the rounding of depth buffers, may
# cause [m]. A pixel is 22 mm wide at the depth of the items, and the test is 3 pixels inside.
BOX_DEPTH = 0.0005
SPHERE_DEPTH = 0.02

# name, shape, radius or edges [m], location [m], axis and angle of the orientation [deg]
ITEMS = [
    ("ball", "sphere", [0.8], (-1.5, 0.8, 0.5), (0, 1, 0), 0),
    ("pearl", "sphere", [0.15], (0.6, 0.4, 2.6), (0, 1, 0), 0),
    ("moon", "sphere", [1.4], (2.0, 1.6, -3.0), (0, 1, 0), 0),
    ("crate", "box", [1.0, 1.4, 0.8], (0.9, 0.7, 0.4), (0, 1, 0), 30),
    ("plank", "box", [3.0, 0.3, 0.4], (-0.4, 2.2, -0.6), (0, 0, 1), 25),
    ("stone", "box", [0.7, 0.5, 0.9], (-3.5, 0.8, 0.0), (1, 0, 0), 50),
]


def quaternion(axis, degrees):
    """Returns x, y, z, w of a rotation around a unit vector."""
    half = math.radians(degrees) / 2
    return [*(math.sin(half) * part for part in axis), math.cos(half)]


def world():
    """Returns the scene as a world file."""
    items = []
    for name, shape, size, location, axis, degrees in ITEMS:
        form = {"shape": shape, "location": location, "orientation": quaternion(axis, degrees)}
        form |= {"radius": size[0]} if shape == "sphere" else {"size": size}
        items.append({"name": name, "physical": form})
    camera = {"eye": EYE, "target": TARGET, "fov": f"{FOV} deg"}
    return json.dumps({"reve": 1, "name": "still", "camera": camera, "items": items})


def mujoco_scene():
    """Returns the scene in MuJoCo's format."""

    def cross(a, b):
        return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]

    def text(numbers):
        return " ".join(repr(float(number)) for number in numbers)

    back = [a - b for a, b in zip(EYE, TARGET)]
    right = cross((0, 1, 0), back)
    up = cross(back, right)
    geoms = ""
    for name, shape, size, location, axis, degrees in ITEMS:
        x, y, z, w = quaternion(axis, degrees)
        halves = size if shape == "sphere" else [edge / 2 for edge in size]
        geoms += (
            f'<geom name="{name}" type="{shape}" size="{text(halves)}" '
            f'pos="{text(location)}" quat="{text([w, x, y, z])}"/>'
        )
    return f"""
    <mujoco>
      <statistic extent="1" center="0 0 0"/>
      <visual>
        <global offwidth="{WIDTH}" offheight="{HEIGHT}"/>
        <quality offsamples="0" numslices="256" numstacks="256"/>
        <map znear="1" zfar="40"/>
      </visual>
      <worldbody>
        <light pos="-5 10 4" dir="5 -10 -4"/>
        <camera name="eye" pos="{text(EYE)}" xyaxes="{text(right)} {text(up)}" fovy="{FOV}"/>
        {geoms}
      </worldbody>
    </mujoco>
    """


# MuJoCo chooses its graphics library when it is imported, so it runs in a process of its own.
DRAW = """
import sys
import mujoco, numpy
model = mujoco.MjModel.from_xml_string(sys.stdin.read())
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
renderer = mujoco.Renderer(model, {height}, {width})
renderer.update_scene(data, "eye")
renderer.enable_depth_rendering()
numpy.save(sys.argv[1] + "/depth.npy", renderer.render())
renderer.disable_depth_rendering()
renderer.enable_segmentation_rendering()
numpy.save(sys.argv[1] + "/geoms.npy", renderer.render()[..., 0])
renderer.close()
"""


def draw_with_mujoco(folder):
    """Returns the depths [m] and the numbers of the geoms, -1 for none, of all pixels."""
    import numpy

    done = subprocess.run(
        [sys.executable, "-c", DRAW.format(width=WIDTH, height=HEIGHT), str(folder)],
        input=mujoco_scene(),
        env=os.environ | {"MUJOCO_GL": "osmesa", "PYOPENGL_PLATFORM": "osmesa"},
        capture_output=True,
        text=True,
    )
    if not (folder / "geoms.npy").exists():
        raise unittest.SkipTest("MuJoCo cannot draw with OSMesa: " + done.stderr[-500:])
    return numpy.load(folder / "depth.npy"), numpy.load(folder / "geoms.npy")


def draw_with_reve(folder):
    """Returns the depths [m] and the ids of the items, 0 for none, of all pixels."""
    import numpy

    (folder / "world.json").write_text(world())
    command = [ROOT / "reve", "picture", folder / "world.json", "--size", f"{WIDTH}x{HEIGHT}"]
    command += ["--depth", folder / "d.npy", "--segmentation", folder / "i.npy"]
    done = subprocess.run(
        [*command, "--out", folder / "picture.png"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return numpy.load(folder / "d.npy"), numpy.load(folder / "i.npy")


def grown(mask, pixels):
    """Returns the pixels that are at most some pixels away from those of a mask."""
    import numpy

    for _ in range(pixels):
        padded = numpy.pad(mask, 1)
        parts = [
            padded[row : row + mask.shape[0], column : column + mask.shape[1]]
            for row in range(3)
            for column in range(3)
        ]
        mask = numpy.logical_or.reduce(parts)
    return mask


def inner(mask, pixels):
    """Returns the pixels of a mask that are more than some pixels away from all others."""
    return ~grown(~mask, pixels)


@unittest.skipIf(MISSING, f"these packages are not installed: {', '.join(MISSING)}")
class MujocoPictures(unittest.TestCase):
    def test_outlines_and_depths_agree(self):
        import numpy

        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            other_depth, geoms = draw_with_mujoco(folder)
            depth, ids = draw_with_reve(folder)
        self.assertEqual(ids.shape, geoms.shape)
        # Items have ascending ids in the order of the world file.
        known = [number for number in numpy.unique(ids) if number != 0]
        self.assertEqual(len(known), len(ITEMS), known)
        for number, (name, shape, *_) in enumerate(ITEMS):
            mine, other = ids == known[number], geoms == number
            self.assertGreater(mine.sum(), 50, name)
            self.assertFalse((mine & ~grown(other, 1)).any(), f"{name} is wider than MuJoCo's")
            self.assertFalse((other & ~grown(mine, 1)).any(), f"{name} is narrower than MuJoCo's")
            inside = inner(mine, 3) & inner(other, 3)
            self.assertGreater(inside.sum(), 5, name)
            difference = numpy.abs(depth - other_depth)[inside].max()
            print(
                f"{name}: {mine.sum()} px, outlines differ in {(mine ^ other).sum()} px,", end=" "
            )
            print(f"depths by at most {1000 * difference:.3f} mm")
            self.assertLess(difference, SPHERE_DEPTH if shape == "sphere" else BOX_DEPTH, name)


if __name__ == "__main__":
    unittest.main()
