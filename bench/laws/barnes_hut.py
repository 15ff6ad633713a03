"""barnes_hut_gravitation through the engine next to pytreegrav, in turn, at about equal errors.

usage: barnes_hut.py BENCH_PROGRAM FOLDER_OF_LAWS [BODIES...]
Needs numpy, numba and pytreegrav. Prints a table; see docs/benchmarks.md.
"""
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numba
import numpy as np
import pytreegrav

SOFTENING = 1e-4
THREADS = 2
ROUNDS = 5
# pytreegrav's opening angle and whether it uses quadrupoles; the law's theta of about that error.
CASES = [(0.7, False, 0.88), (0.5, True, 0.47)]


def plummer(bodies):
    """Points of a Plummer sphere of radius 1 m, (bodies x 3)."""
    random = np.random.default_rng(7)
    radius = 1 / np.sqrt(random.uniform(0.001, 0.99, bodies) ** (-2 / 3) - 1)
    direction = random.normal(size=(bodies, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return np.ascontiguousarray(direction * radius[:, None])


@numba.njit(parallel=True)
def direct(points, rows):
    """Accelerations of some rows by the sum over all bodies."""
    out = np.zeros((rows.size, 3))
    for k in numba.prange(rows.size):
        for j in range(points.shape[0]):
            d = points[j] - points[rows[k]]
            out[k] += d * (np.sum(d * d) + SOFTENING**2) ** -1.5
    return out / points.shape[0]


def median_error(accelerations, rows, exact):
    wrong = np.linalg.norm(accelerations[rows] - exact, axis=1)
    return np.median(wrong / np.linalg.norm(exact, axis=1))


class Law:
    """The bench program, a step at a time."""

    def __init__(self, program, laws, precision, theta, folder):
        self.result = folder / f"{precision}.bin"
        self.process = subprocess.Popen(
            [program, laws, precision, str(theta), str(SOFTENING), folder / "points.bin", self.result],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def step(self):
        """Seconds on the wall and of processor time."""
        print(file=self.process.stdin, flush=True)
        return tuple(map(float, self.process.stdout.readline().split()))

    def finish(self):
        """The accelerations, (bodies x 3)."""
        self.process.communicate()
        return np.fromfile(self.result).reshape(-1, 3)


def compare(program, laws, folder, points, case):
    angle, quadrupole, theta = case
    bodies = len(points)
    masses = np.full(bodies, 1 / bodies)
    # Its softening is a cubic spline of this support, as soft in the middle as Plummer's.
    softening = np.full(bodies, 2.8 * SOFTENING)
    rows = np.random.default_rng(3).choice(bodies, 1000, replace=False)
    exact = direct(points, rows)
    sides = {p: Law(program, laws, p, theta, folder) for p in ("f32", "f64")}
    times = {"f32": [], "f64": [], "peer": []}
    for _ in range(ROUNDS + 1):
        for precision, law in sides.items():
            times[precision].append(law.step())
        wall, processor = time.perf_counter(), time.process_time()
        peer = pytreegrav.Accel(points, masses, softening=softening, theta=angle, parallel=True,
                                method="tree", quadrupole=quadrupole)
        times["peer"].append((time.perf_counter() - wall, time.process_time() - processor))
    # The first round warms up.
    wall, processor = ({side: statistics.median(t[i] for t in of[1:]) for side, of in times.items()}
                       for i in (0, 1))
    peer_error = median_error(peer, rows, exact)
    for precision, law in sides.items():
        error = median_error(law.finish(), rows, exact)
        print(f"| {bodies} | {precision} | {error:.2e} | {peer_error:.2e} | "
              f"{bodies / wall[precision] / 1000:.0f} | {bodies / wall['peer'] / 1000:.0f} | "
              f"{wall['peer'] / wall[precision]:.1f} | "
              f"{processor['peer'] / processor[precision]:.1f} |", flush=True)


def main():
    program, laws, *sizes = sys.argv[1:]
    numba.set_num_threads(THREADS)
    print("| bodies | law | its median error | pytreegrav's | law [1000 bodies/s] | "
          "pytreegrav [1000 bodies/s] | ratio | ratio of processor time |\n"
          "|---:|---|---:|---:|---:|---:|---:|---:|", flush=True)
    with tempfile.TemporaryDirectory() as name:
        for size in map(int, sizes or (100_000, 1_000_000)):
            points = plummer(size)
            points.tofile(pathlib.Path(name) / "points.bin")
            for case in CASES:
                compare(program, laws, pathlib.Path(name), points, case)


if __name__ == "__main__":
    main()
