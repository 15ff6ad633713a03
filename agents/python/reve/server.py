# SPDX-License-Identifier: Apache-2.0
"""The commands `serve`, `experiment` and `pack` of the project's launcher."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import tempfile
import threading
from typing import IO, Any, Callable, Dict, Iterator, List, Optional, Tuple, Union

from .errors import ReveError

_SECONDS_TO_END = 30


@contextlib.contextmanager
def serve(
    world: Union[str, "os.PathLike[str]"],
    *options: str,
    launcher: Union[str, "os.PathLike[str]"] = "./reve",
) -> Iterator[Tuple[str, int]]:
    """Runs `./reve serve WORLD` on a free port. Yields host and port, and ends the server
    afterwards. The server also ends if this process is killed.

    The server makes frames as fast as its agents in lock-step allow. It waits at most an hour for
    an agent in each round. `options` are further options of `./reve serve`. `launcher` is the
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
        "--until-input-ends",
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
                assert process.stdin is not None
                process.stdin.close()
                _await(process)


def experiment(
    file: Union[str, "os.PathLike[str]"],
    *options: str,
    launcher: Union[str, "os.PathLike[str]"] = "./reve",
    on_run: Optional[Callable[[Dict[str, Any]], None]] = None,
) -> Dict[str, Any]:
    """Runs `./reve experiment FILE` to its end and returns its result, the document of `--json`.

    The field `identical` states whether the result equals the earlier results in the folder, if
    there are any. Each of its `runs` has a `state`. `options` are further options of the command.
    `launcher` is the project's launcher. `on_run` is called with each run as soon as it has ended:
    a dict with the fields of a run, `ended` (the number of runs that have ended), and `runs` (the
    number of all runs). If `on_run` raises an exception, the command is ended. Raises ReveError
    with the command's output if the experiment cannot be run.
    """
    command = [os.fspath(launcher), "experiment", os.fspath(file), "--json-lines", *options]
    result: Optional[Dict[str, Any]] = None
    with tempfile.TemporaryFile("w+") as errors:
        process = _start(command, errors, "no-experiment")
        assert process.stdout is not None and process.stdin is not None
        process.stdin.close()
        try:
            with process.stdout as lines:
                for line in lines:
                    event = _event(line)
                    if event.pop("event", None) == "result":
                        result = event
                    elif event and on_run is not None:
                        on_run(event)
        except BaseException:
            process.terminate()
            raise
        finally:
            _await(process)
        if result is None:
            errors.seek(0)
            raise ReveError("no-experiment", f"`{' '.join(command)}`: {errors.read().strip()}")
        return result


def pack(
    source: Union[str, "os.PathLike[str]"],
    *options: str,
    out: Union[str, "os.PathLike[str]", None] = None,
    at: Optional[float] = None,
    frame: Optional[int] = None,
    world: Union[str, "os.PathLike[str]", None] = None,
    launcher: Union[str, "os.PathLike[str]"] = "./reve",
) -> Dict[str, Any]:
    """Runs `./reve pack` and returns its result, the document of `--json`.

    `source` is a world, a recording or a store. `out` is the file of the pack, by default
    `NAME.reve` in the current folder. For a recording or a store, `at` [s] or `frame` chooses the
    state, and `world` names the world file of the run. `options` are further options of the
    command. `launcher` is the project's launcher.

    The field `pack` of the result is the file, and `needsTrust` states whether it contains native
    code. `notes` lists the parts of a recorded state that the pack does not contain. Raises
    ReveError with the command's output if no pack was made.
    """
    command = [os.fspath(launcher), "pack", os.fspath(source), "--json"]
    chosen: Dict[str, Union[str, float, "os.PathLike[str]", None]]
    chosen = {"--out": out, "--at": at, "--frame": frame, "--world": world}
    for option, value in chosen.items():
        if value is not None:
            command += [option, value if isinstance(value, str) else _text(value)]
    command += options
    with tempfile.TemporaryFile("w+") as errors:
        process = _start(command, errors, "no-pack")
        assert process.stdout is not None and process.stdin is not None
        process.stdin.close()
        try:
            with process.stdout as document:
                result = _event(document.read())
        except BaseException:
            process.terminate()
            raise
        finally:
            _await(process)
        if process.returncode != 0 or "pack" not in result:
            errors.seek(0)
            raise ReveError("no-pack", f"`{' '.join(command)}`: {errors.read().strip()}")
        return result


def _text(value: Union[float, "os.PathLike[str]"]) -> str:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    number = float(value)  # NumPy's numbers have another repr
    return str(int(number)) if number.is_integer() else repr(number)


def _event(line: str) -> Dict[str, Any]:
    try:
        event = json.loads(line)
    except ValueError:
        return {}
    return event if isinstance(event, dict) else {}


def _await(process: "subprocess.Popen[str]") -> None:
    """Waits for the end of a process that has closed its output or was terminated."""
    try:
        process.wait(_SECONDS_TO_END)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _start(
    command: List[str], errors: IO[str], reason: str = "no-server"
) -> "subprocess.Popen[str]":
    try:
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True
        )
    except OSError as error:
        raise ReveError(
            reason,
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
