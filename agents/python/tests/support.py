# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the tests: the package under test, the protocol's vectors, and a real server."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import Any, Iterator, List

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parent
PROTOCOL = PACKAGE.parent / "protocol"
PATIENT = HERE / "patient"

PATIENCE = 1800  # seconds for a program to end; other tests may occupy the machine for minutes
# The environment of programs in Python that use the client: they are patient, too.
ENVIRONMENT = {**os.environ, "PYTHONPATH": f"{PATIENT}{os.pathsep}{PACKAGE}"}

sys.path.insert(0, str(PACKAGE))


def vectors(name: str) -> List[Any]:
    """Returns one value per line of a file of test vectors."""
    text = (PROTOCOL / "vectors" / name).read_text("utf-8")
    return [json.loads(line) for line in text.splitlines()]


def tool(program: str, *options: str) -> List[str]:
    """Returns the start of the command of a program of the JDK, with the project's classes."""
    class_path = os.environ.get("REVE_TEST_CLASSPATH")
    java_home = os.environ.get("REVE_JAVA_HOME")
    if not class_path or not java_home:
        raise RuntimeError(
            "these tests start Java programs: set REVE_TEST_CLASSPATH to their class path and "
            "REVE_JAVA_HOME to a JDK 25, or run `./reve test`, which does"
        )
    return [f"{java_home}/bin/{program}", *options, "-cp", class_path]


def java(program: str, *arguments: str) -> List[str]:
    """Returns the command that runs a class, or a Java source file, with the project's classes."""
    # The programs live for seconds: see SHORT_LIVED in scripts/run_tests.py.
    options = ["-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1", "--enable-native-access=ALL-UNNAMED"]
    return [*tool("java", *options), program, *arguments]


@functools.cache
def pond_classes() -> "tempfile.TemporaryDirectory[str]":
    """Compiles PondServer.java once; the folder of its classes is removed at the end."""
    folder = tempfile.TemporaryDirectory()
    compiler = tool("javac", "-proc:none", "-d", folder.name)
    subprocess.run([*compiler, str(HERE / "PondServer.java")], check=True)
    return folder


@contextlib.contextmanager
def launched(*arguments: str) -> Iterator[int]:
    """Runs `./reve` with arguments that start a server; yields its port."""
    root = PACKAGE.parents[1]
    server = subprocess.Popen(
        [str(root / "reve"), *arguments, "--json"], cwd=root, stdout=subprocess.PIPE, text=True
    )
    try:
        assert server.stdout is not None
        events = (json.loads(line) for line in server.stdout)
        yield next(event["agentPort"] for event in events if event["event"] == "ready")
    finally:
        server.terminate()
        server.communicate(timeout=PATIENCE)


@contextlib.contextmanager
def pond() -> Iterator[int]:
    """Runs a server with the world of pond.yaml as a separate process; yields its port."""
    command = java("PondServer", str(HERE / "pond.yaml"))
    command[command.index("-cp") + 1] += os.pathsep + pond_classes().name
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdin is not None and server.stdout is not None
        line = server.stdout.readline()
        if not line.strip().isdigit():
            raise RuntimeError(f"the server did not start: {' '.join(command)} said {line!r}")
        yield int(line)
    finally:
        server.stdin.close()
        server.stdout.close()
        server.wait(timeout=PATIENCE)
