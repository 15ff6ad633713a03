# SPDX-License-Identifier: Apache-2.0
"""Sides that do the same work and are timed in turn: those of gravitation_bench, and functions of
this module."""

import argparse
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

import numba
import numpy as np

THREADS = 2


def arguments(description, sizes):
    """Returns the arguments of a table's program: PROGRAM, FOLDER_OF_LAWS, numbers of bodies,
    --quick."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("program", help="gravitation_bench")
    parser.add_argument("laws", help="folder of laws")
    parser.add_argument("bodies", nargs="*", type=int, default=sizes, help="numbers of bodies")
    parser.add_argument("--quick", action="store_true", help="one short round")
    return parser.parse_args()


def rounds(given, count):
    """Returns the arguments of in_turn: a number of rounds, or one short round with --quick."""
    return {"rounds": 1, "seconds": 0.02} if given.quick else {"rounds": count}


class Program:
    """A context that runs gravitation_bench with some sides over points, (bodies x 3) [m]."""

    def __init__(self, given, precision, softening, points, *sides):
        self.folder = tempfile.TemporaryDirectory()
        self.result = pathlib.Path(self.folder.name) / "result"
        positions = pathlib.Path(self.folder.name) / "positions"
        points.astype(np.float64).tofile(positions)
        self.sides = len(sides)
        self.process = subprocess.Popen(
            [
                given.program,
                given.laws,
                precision,
                str(softening),
                positions,
                self.result,
                *sides,
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"OMP_WAIT_POLICY": "passive"},
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.communicate()
        self.folder.cleanup()

    def side(self, number):
        """Returns a function that times a number of calls. Its results are wall-clock and processor
        time per call [s]."""

        def run(calls):
            print(number, calls, file=self.process.stdin, flush=True)
            return tuple(map(float, self.process.stdout.readline().split()))

        return run

    def finish(self):
        """Ends the program; returns its accelerations, (sides x bodies x 3)."""
        self.process.communicate()
        return np.fromfile(self.result).reshape(self.sides, -1, 3)


def timed(action):
    """Returns a function that times a number of calls of a function of this process."""

    def run(calls):
        wall, processor = time.perf_counter(), time.process_time()
        for _ in range(calls):
            action()
        return (time.perf_counter() - wall) / calls, (time.process_time() - processor) / calls

    return run


def busy():
    """Returns the time [s] that all programs have used on all processors."""
    ticks = list(map(int, pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]))
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")


def in_turn(sides, rounds=5, seconds=0.2):
    """Runs the sides (a dictionary) in rounds, each for about `seconds`.

    Returns, by name, the median seconds of a call in wall-clock and in processor time, and the
    number of processors used by other programs.
    """
    calls = {}
    for name, run in sides.items():
        calls[name] = 1
        while run(calls[name])[0] * calls[name] < seconds / 2:
            calls[name] *= 2
    times = {name: [] for name in sides}
    start, others = time.perf_counter(), busy()
    for _ in range(rounds):
        for name, run in sides.items():
            times[name].append(run(calls[name]))
    others = busy() - others - sum(calls[n] * t[1] for n in sides for t in times[n])
    medians = {n: tuple(statistics.median(t[i] for t in times[n]) for i in (0, 1)) for n in sides}
    return medians, max(0, others / (time.perf_counter() - start))


@numba.njit(fastmath=True, parallel=True)
def attract(x, y, z, m, ax, ay, az, softening2):
    """Computes accelerations by the sum over all pairs, in the precision of the arrays."""
    for i in numba.prange(x.size):
        a = b = c = x.dtype.type(0)
        for j in range(x.size):
            dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
            inverse = x.dtype.type(1) / np.sqrt(dx * dx + dy * dy + dz * dz + softening2)
            pull = m[j] * inverse * inverse * inverse
            a += pull * dx
            b += pull * dy
            c += pull * dz
        ax[i], ay[i], az[i] = a, b, c


def exact(points, rows, softening, real=np.float64):
    """Returns accelerations of some rows in a precision; the total mass is 1 kg, and G = 1."""
    points = points.astype(real)
    out = np.zeros((len(rows), 3), real)
    for k, row in enumerate(rows):
        d = points - points[row]
        out[k] = d.T @ ((d * d).sum(1) + real(softening) ** 2) ** real(-1.5)
    return out / len(points)


def errors(accelerations, rows, expected):
    """Returns the errors of the rows, relative to the expected values."""
    wrong = np.linalg.norm((accelerations[rows] - expected).astype(np.float64), axis=1)
    return wrong / np.linalg.norm(expected.astype(np.float64), axis=1)
