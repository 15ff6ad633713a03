# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the tests: the package under test, the protocol's vectors, and a real server."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import subprocess
import sys
from typing import Any, Iterator, List

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parent
PROTOCOL = PACKAGE.parent / "protocol"

sys.path.insert(0, str(PACKAGE))


def vectors(name: str) -> List[Any]:
    """Returns one value per line of a file of test vectors."""
    text = (PROTOCOL / "vectors" / name).read_text("utf-8")
    return [json.loads(line) for line in text.splitlines()]


def java(program: str, *arguments: str) -> List[str]:
    """Returns the command that runs a class, or a Java source file, with the project's classes."""
    class_path = os.environ.get("REVE_TEST_CLASSPATH")
    java_home = os.environ.get("REVE_JAVA_HOME")
    if not class_path or not java_home:
        raise RuntimeError(
            "these tests start Java programs: set REVE_TEST_CLASSPATH to their class path and "
            "REVE_JAVA_HOME to a JDK 25, or run `./reve test`, which does"
        )
    java = [f"{java_home}/bin/java", "--enable-native-access=ALL-UNNAMED", "-cp", class_path]
    return [*java, program, *arguments]


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
        server.communicate(timeout=30)


@contextlib.contextmanager
def pond() -> Iterator[int]:
    """Runs a server with the world of pond.yaml as a separate process; yields its port."""
    command = java(str(HERE / "PondServer.java"), str(HERE / "pond.yaml"))
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
        server.wait(timeout=30)
