# SPDX-License-Identifier: Apache-2.0
"""Runs the examples in the documents unchanged against a real server; only the port is replaced."""

import json
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import unittest
import zipfile
from typing import List

import pytest
import reve
from support import ENVIRONMENT, PACKAGE, PATIENCE, java, launched, pond

README = PACKAGE / "README.md"
ROOT = PACKAGE.parents[1]
PAGE = ROOT / "docs" / "agents.md"


def examples(document: pathlib.Path, language: str, port: int) -> List[str]:
    """Returns the code blocks in that language; "" selects those without a language."""
    text = document.read_text("utf-8")
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [code.replace("7777", str(port)) for name, code in blocks if name == language]


def python(script: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", script],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


class ReadmeTest(unittest.TestCase):
    def test_its_example_runs(self):
        with pond() as port:
            for script in examples(README, "python", port):
                run = python(script)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertRegex(run.stdout, "duck .*accepted=True")


class PageTest(unittest.TestCase):
    """Tests docs/agents.md, in the world that its first command serves."""

    @classmethod
    def setUpClass(cls):
        page = PAGE.read_text("utf-8")
        command = re.search(r"^    \./reve (serve .*)$", page, re.MULTILINE).group(1)
        cls.server = launched(*command.replace("7777", "0").split())
        cls.port = cls.server.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__(None, None, None)

    def test_the_first_python_example_moves_a_body(self):
        with reve.control(port=self.port) as world:
            world.rewind()
            self.assertEqual(world.perceive().find("blue").location[2], 0.0)
            run = python(examples(PAGE, "python", self.port)[0])
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertGreater(world.perceive().find("blue").location[2], 0.0)

    def test_the_python_examples_run(self):
        for script in examples(PAGE, "python", self.port):
            with self.subTest(script=script):
                run = python(script)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertRegex(run.stdout, "blue|accepted=True")
                self.assertNotRegex(run.stdout, "refused|accepted=False")

    def test_the_java_examples_run(self):
        for example in examples(PAGE, "java", self.port):
            with self.subTest(example=example), tempfile.TemporaryDirectory() as folder:
                source = pathlib.Path(folder, "Example.java")
                source.write_text(example, "utf-8")
                run = subprocess.run(
                    java(str(source)), capture_output=True, text=True, timeout=PATIENCE
                )
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertIn("red painted", run.stdout)
                self.assertNotIn("false", run.stdout)

    def test_the_lines_typed_by_hand_are_answered_as_described(self):
        lines = examples(PAGE, "", self.port)[0]
        expected = {"hello": "welcome", "perceive": "perception", "act": "result", "bye": "bye"}
        address = ("127.0.0.1", self.port)
        with socket.create_connection(address, timeout=PATIENCE) as connection:
            answers = connection.makefile("r", encoding="utf-8")
            for line in lines.splitlines():
                connection.sendall(line.encode() + b"\n")
                wanted = expected[re.search(r'"t":"(\w+)"', line).group(1)]
                answer = answers.readline()
                while '"t":"event"' in answer:
                    answer = answers.readline()
                self.assertIn(f'"t":"{wanted}"', answer)
                self.assertNotIn('"accepted":false', answer)
            self.assertEqual(answers.readline(), "")


class ExperimentsTest(unittest.TestCase):
    """Tests the example in Python of docs/experiments.md, with the files of this page."""

    def test_an_experiment_is_run_and_read_as_the_page_says(self):
        page = (ROOT / "docs" / "experiments.md").read_text("utf-8")
        files = dict(re.findall(r"^```\w+ title=(\S+)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL))
        with tempfile.TemporaryDirectory() as folder:
            for name in ("syrup.yaml", "sinking.yaml", "read.py"):
                pathlib.Path(folder, name).write_text(files[name], "utf-8")
            run = subprocess.run(
                [sys.executable, "read.py"],
                cwd=folder,
                env={**ENVIRONMENT, "REVE": str(ROOT)},
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(run.stdout, files["read"])
            with self.assertRaisesRegex(reve.ReveError, "there is no experiment file nothing"):
                reve.experiment("nothing", launcher=ROOT / "reve")
            out = pathlib.Path(folder, "stopped")
            with self.assertRaises(KeyError):
                reve.experiment(
                    pathlib.Path(folder, "sinking.yaml"),
                    "--jobs=1",
                    f"--out={out}",
                    launcher=ROOT / "reve",
                    on_run=lambda run: run["no such field"],
                )
            self.assertTrue((out / "unfinished.jsonl").exists() or (out / "result.json").exists())


@pytest.mark.slow
class PacksTest(unittest.TestCase):
    """Tests the example in Python of docs/world-file.md, with a recording of a sample world."""

    def test_packs_of_worlds_and_recordings_are_made_as_the_page_says(self):
        page = (ROOT / "docs" / "world-file.md").read_text("utf-8")
        files = dict(re.findall(r"^```\w+ title=(\S+)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL))
        launcher = ROOT / "reve"
        orbit = ROOT / "worlds" / "spring-orbit"
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder, "run.log")
            subprocess.run(
                [launcher, "run", orbit, "--seconds", "1", "--record", log],
                check=True,
                capture_output=True,
                timeout=PATIENCE,
            )
            pathlib.Path(folder, "share.py").write_text(files["share.py"], "utf-8")
            run = subprocess.run(
                [sys.executable, "share.py"],
                cwd=folder,
                env={**ENVIRONMENT, "REVE": str(ROOT)},
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(run.stdout, files["share"])

            half = pathlib.Path(folder, "half.reve")
            again = pathlib.Path(folder, "again.reve")
            made = reve.pack(log, frame=30, world=orbit, out=again, launcher=launcher)
            self.assertEqual(again.read_bytes(), half.read_bytes())
            self.assertEqual(made["bytes"], len(half.read_bytes()))
            self.assertEqual(made["notes"], [])
            with zipfile.ZipFile(half) as pack:
                self.assertEqual(sorted(pack.namelist()), made["files"])
                expected = json.loads(pack.read("expected.json"))
            ran = subprocess.run(
                [launcher, "run", half, "--seconds", "0.5", "--json"],
                check=True,
                capture_output=True,
                timeout=PATIENCE,
            )
            self.assertEqual(expected["frames"], 30)
            self.assertEqual(json.loads(ran.stdout)["stateHash"], expected["stateHash"])

            whole = reve.pack(str(orbit), out=str(half), launcher=launcher)
            self.assertEqual(whole["world"], "spring-orbit")
            self.assertNotIn("frame", whole)
            with self.assertRaisesRegex(reve.ReveError, "ends at frame 60") as refused:
                reve.pack(log, at=2, out=half, launcher=launcher)
            self.assertEqual(refused.exception.code, "no-pack")
            with self.assertRaisesRegex(reve.ReveError, "cannot run /nowhere/reve"):
                reve.pack(log, launcher="/nowhere/reve")


if __name__ == "__main__":
    unittest.main()
