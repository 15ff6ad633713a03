# SPDX-License-Identifier: Apache-2.0
"""Formats the sources; with --check, lists the files that a formatter would change.

    format.py ROOT [--check] [--report REPORT.xml]

Formats Java with google-java-format (`--aosp`), C and C++ with clang-format (`.clang-format`),
Python with ruff (`ruff.toml`), and checks shell scripts with shellcheck, which changes nothing.
`./reve format` calls this script when the formatters are installed: REVE_TOOLS is a Python
environment with clang-format and ruff, build/formatter-class-path.txt contains google-java-format.
--report writes a JUnit report with one test for each formatter. Exits with 1 if a file still needs
changes.
"""

import argparse
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

# google-java-format uses the internal parser of the Java compiler, in these packages.
COMPILER_PACKAGES = ["api", "code", "file", "parser", "tree", "util"]


def sources(root, *endings):
    """Returns the files of the project with these endings: tracked and new ones."""
    listing = subprocess.run(
        ["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        stdout=subprocess.PIPE,
        check=True,
    )
    paths = [root / os.fsdecode(name) for name in listing.stdout.split(b"\0") if name]
    return sorted(
        str(path)
        for path in paths
        if path.suffix in endings and path.is_file() and not path.is_symlink()
    )


def shell_scripts(root):
    named = [path for path in sources(root, "", ".sh") if Path(path).read_bytes()[:2] == b"#!"]
    return [path for path in named if b"sh" in Path(path).read_bytes().split(b"\n", 1)[0]]


def run(command, **options):
    return subprocess.run(
        command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options
    )


def google_java_format(root, *arguments):
    class_path = (root / "build/formatter-class-path.txt").read_text().strip()
    exports = [
        f"--add-exports=jdk.compiler/com.sun.tools.javac.{package}=ALL-UNNAMED"
        for package in COMPILER_PACKAGES
    ]
    files = root / "build/java-files.txt"
    files.write_text("\n".join(sources(root, ".java")))
    return run(
        [
            os.environ["REVE_JAVA_HOME"] + "/bin/java",
            "-Xshare:auto",
            *exports,
            "-cp",
            class_path,
            "com.google.googlejavaformat.java.Main",
            "--aosp",
            "--skip-reflowing-long-strings",  # because it fails on escapes of surrogate pairs
            *arguments,
            f"@{files}",
        ]
    )


def java(root, check):
    if check:
        return google_java_format(root, "--dry-run", "--set-exit-if-changed")
    return google_java_format(root, "--replace")


def native(root, check):
    tool = os.environ["REVE_TOOLS"] + "/clang-format"
    files = sources(root, ".c", ".h", ".cpp", ".hpp")
    if not check:
        return run([tool, "-i", *files])
    done = run([tool, "--dry-run", "--Werror", *files])
    done.stdout = (
        "\n".join(sorted(set(re.findall(r"^(.+?):\d+:\d+: error", done.stdout, re.M))))
        or done.stdout
    )
    return done


def python(root, check):
    tool = os.environ["REVE_TOOLS"] + "/ruff"
    files = sources(root, ".py")
    formatted = run([tool, "format", "--quiet", *(["--diff"] if check else []), *files], cwd=root)
    found = run([tool, "check", "--quiet", *([] if check else ["--fix"]), *files], cwd=root)
    found.returncode = found.returncode or formatted.returncode
    found.stdout = formatted.stdout + found.stdout
    return found


def shell(root, check):
    return run(["shellcheck", "-x", "--severity=warning", "-P", str(root), *shell_scripts(root)])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=Path)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--report", type=Path)
    given = parser.parse_args()
    suite = ET.Element("testsuite", name="format")
    failed = False
    for formatter in (java, native, python, shell):
        done = formatter(given.root, given.check)
        case = ET.SubElement(suite, "testcase", name=formatter.__name__)
        print(f"format.py::{formatter.__name__} {'FAILED' if done.returncode else 'PASSED'}")
        if done.returncode:
            failed = True
            text = done.stdout.replace(f"{given.root}/", "")
            ET.SubElement(case, "failure", message="run ./reve format; it concerns").text = text
            print(text)
    if given.report:
        ET.ElementTree(suite).write(given.report, encoding="utf-8", xml_declaration=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
