# SPDX-License-Identifier: Apache-2.0
"""Tests of the package as a whole: it can be installed, and its types are correct."""

import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import pytest
from support import PACKAGE, PATIENCE


def installed(*packages):
    return all(importlib.util.find_spec(package) for package in packages)


@pytest.mark.slow
class PackageTest(unittest.TestCase):
    @unittest.skipUnless(
        installed("pip", "setuptools", "wheel"), "pip, setuptools and wheel are not installed"
    )
    def test_pip_installs_all_of_it(self):
        with tempfile.TemporaryDirectory() as folder:
            source, target = pathlib.Path(folder, "source"), pathlib.Path(folder, "target")
            shutil.copytree(PACKAGE, source, ignore=shutil.ignore_patterns("__pycache__", "tests"))
            install = [
                sys.executable,
                "-m",
                "pip",
                "install",
                "-q",
                "--no-index",
                "--no-deps",
                "--no-build-isolation",
            ]
            run = subprocess.run(
                [*install, "--target", str(target), str(source)],
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            files = [
                f.relative_to(PACKAGE)
                for f in (PACKAGE / "reve").rglob("*")
                if f.suffix in (".py", ".typed")
            ]
            self.assertIn(pathlib.Path("reve", "py.typed"), files)
            self.assertEqual([f for f in files if not (target / f).exists()], [])

    @unittest.skipUnless(
        installed("mypy", "gymnasium", "pettingzoo"), "mypy and the extra gym are not installed"
    )
    def test_its_types_hold(self):
        with tempfile.TemporaryDirectory() as cache:
            run = subprocess.run(
                [
                    sys.executable,
                    "-m",
                    "mypy",
                    "--config-file",
                    str(PACKAGE / "pyproject.toml"),
                    "--cache-dir",
                    cache,
                    str(PACKAGE / "reve"),
                ],
                capture_output=True,
                text=True,
                timeout=3600,
            )
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
