# SPDX-License-Identifier: Apache-2.0
"""Sides that do the same work, timed in turn: those of gravitation_bench, and functions here."""

import os
import pathlib
import statistics
import subprocess
import tempfile
import time

import numba
import numpy as np

THREADS = 2


class Program:
    """gravitation_bench with some sides over points, (bodies x 3) [m]. A context."""

    def __init__(self, program, laws, precision, softening, points, *sides):
        self.folder = tempfile.TemporaryDirectory()
        self.result = pathlib.Path(self.folder.name) / "result"
        positions = pathlib.Path(self.folder.name) / "positions"
        points.astype(np.float64).tofile(positions)
        self.sides = len(sides)
        self.process = subprocess.Popen(
            [program, laws, precision, str(softening), positions, self.result, *sides],
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
        """The function that times so many calls: seconds of each, on the wall and of processor
        time."""

        def run(calls):
            print(number, calls, file=self.process.stdin, flush=True)
            return tuple(map(float, self.process.stdout.readline().split()))

        return run

    def finish(self):
        """Ends the program; the accelerations that it found, (sides x bodies x 3)."""
        self.process.communicate()
        return np.fromfile(self.result).reshape(self.sides, -1, 3)


def timed(action):
    """The function that times so many calls of a function of this process."""

    def run(calls):
        wall, processor = time.perf_counter(), time.process_time()
        for _ in range(calls):
            action()
        return (time.perf_counter() - wall) / calls, (time.process_time() - processor) / calls

    return run


def busy():
    """Seconds that the processors have been busy with anything."""
    ticks = list(map(int, pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]))
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")


def in_turn(sides, rounds=5, seconds=0.2):
    """Runs the sides (a dictionary) round by round, each for about so long. The median seconds of a
    call, on the wall and of processor time, by name, and how many processors others kept busy."""
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
    """Accelerations by the sum over all pairs, in the precision of the arrays."""
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
    """Accelerations of some rows, in a precision; the bodies weigh 1 kg together, G = 1."""
    points = points.astype(real)
    out = np.zeros((len(rows), 3), real)
    for k, row in enumerate(rows):
        d = points - points[row]
        out[k] = d.T @ ((d * d).sum(1) + real(softening) ** 2) ** real(-1.5)
    return out / len(points)


def errors(accelerations, rows, expected):
    """Errors of the rows, relative to what is expected of each."""
    wrong = np.linalg.norm((accelerations[rows] - expected).astype(np.float64), axis=1)
    return wrong / np.linalg.norm(expected.astype(np.float64), axis=1)
