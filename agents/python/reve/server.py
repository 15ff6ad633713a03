# SPDX-License-Identifier: Apache-2.0
"""The commands `serve` and `experiment` of the project's launcher."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import tempfile
import threading
from typing import IO, Any, Dict, Iterator, List, Tuple, Union

from .errors import ReveError

_SECONDS_TO_END = 30


@contextlib.contextmanager
def serve(
    world: Union[str, "os.PathLike[str]"],
    *options: str,
    launcher: Union[str, "os.PathLike[str]"] = "./reve",
) -> Iterator[Tuple[str, int]]:
    """Runs `./reve serve WORLD` on a free port. Yields host and port, and ends the server
    afterwards.

    The server makes frames as fast as its agents in lock-step allow. In each round it waits for an
    agent up to an hour. `options` are further options of `./reve serve`, `launcher` is the
    project's launcher. Raises ReveError if the launcher cannot be run, or with the server's output
    if the server does not start.
    """
    command = [
        os.fspath(launcher),
        "serve",
        os.fspath(world),
        "--port",
        "0",
        "--json",
        "--fast",
        "--deadline",
        "3600",
        "--waiting",
        "off",
        *options,
    ]
    with tempfile.TemporaryFile("w+") as errors:
        process = _start(command, errors)
        assert process.stdout is not None
        with process.stdout as events:
            try:
                port = _port(events)
                if port is None:
                    process.wait()
                    errors.seek(0)
                    raise ReveError(
                        "no-server",
                        f"`{' '.join(command)}` did not start: {errors.read().strip()}",
                    )
                threading.Thread(target=_drain, args=(events,), daemon=True).start()
                yield "127.0.0.1", port
            finally:
                process.terminate()
                try:
                    process.wait(_SECONDS_TO_END)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


def experiment(
    file: Union[str, "os.PathLike[str]"],
    *options: str,
    launcher: Union[str, "os.PathLike[str]"] = "./reve",
) -> Dict[str, Any]:
    """Runs `./reve experiment FILE` to its end and returns its result, the document of `--json`.

    The field `identical` of the result states whether it equals the earlier results in the folder,
    if there are any. Each of its `runs` has a `state`. `options` are further options of the
    command, `launcher` is the project's launcher. Raises ReveError with the command's output if the
    experiment cannot be run.
    """
    command = [os.fspath(launcher), "experiment", os.fspath(file), "--json", *options]
    try:
        run = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
        )
    except OSError as error:
        raise ReveError(
            "no-experiment",
            f"cannot run {command[0]}: {error.strerror}",
            "give the path of the project's `reve` as launcher",
        ) from error
    try:
        result: Dict[str, Any] = json.loads(run.stdout)
    except ValueError as error:
        raise ReveError("no-experiment", f"`{' '.join(command)}`: {run.stderr.strip()}") from error
    return result


def _start(command: List[str], errors: IO[str]) -> "subprocess.Popen[str]":
    try:
        return subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors, text=True
        )
    except OSError as error:
        raise ReveError(
            "no-server",
            f"cannot run {command[0]}: {error.strerror}",
            "give the path of the project's `reve` as launcher",
        ) from error


def _port(events: IO[str]) -> "int | None":
    for line in events:
        event = json.loads(line)
        if event.get("event") == "ready":
            return int(event["agentPort"])
    return None


def _drain(events: IO[str]) -> None:
    """Reads and discards the server's output, so that the server never blocks on a full pipe."""
    with contextlib.suppress(OSError, ValueError):  # if another thread closed the stream
        while os.read(events.fileno(), 1 << 16):
            pass
