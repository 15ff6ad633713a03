# SPDX-License-Identifier: Apache-2.0
"""Compares barnes_hut_gravitation in the engine with pytreegrav, in turn, at similar errors.

Prints a table; see docs/benchmarks.md.
"""

import numba
import numpy as np
import pytreegrav
from sides import THREADS, Program, arguments, errors, exact, in_turn, rounds, timed

SOFTENING = 1e-4
# Each case contains pytreegrav's opening angle and its use of quadrupoles. It also contains two
# values of the law's theta with about the same error: for up to 100,000 bodies, and for more
# bodies.
CASES = [(0.7, False, (0.88, 0.78)), (0.5, True, (0.5, 0.48))]


def plummer(bodies):
    """Returns points of a Plummer sphere of radius 1 m, (bodies x 3)."""
    random = np.random.default_rng(7)
    radius = 1 / np.sqrt(random.uniform(0.001, 0.99, bodies) ** (-2 / 3) - 1)
    direction = random.normal(size=(bodies, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return np.ascontiguousarray(direction * radius[:, None])


def compare(given, points, rows, expected, case):
    angle, quadrupole, thetas = case
    bodies = len(points)
    theta = thetas[bodies > 100_000]
    masses = np.full(bodies, 1 / bodies)
    # The softening of pytreegrav is a cubic spline. With this support, it is as soft at the centre
    # as Plummer's softening.
    softening = np.full(bodies, 2.8 * SOFTENING)
    peer = {}

    def accelerate():
        peer["found"] = pytreegrav.Accel(
            points,
            masses,
            softening=softening,
            theta=angle,
            parallel=True,
            method="tree",
            quadrupole=quadrupole,
        )

    law = f"barnes_hut_gravitation theta={theta}"
    with (
        Program(given, "f32", SOFTENING, points, law) as single,
        Program(given, "f64", SOFTENING, points, law) as double,
    ):
        accelerate()  # triggers compilation
        medians, others = in_turn(
            {"f32": single.side(0), "f64": double.side(0), "peer": timed(accelerate)},
            **rounds(given, 5 if bodies < 500_000 else 3),
        )
        found = {"f32": single.finish()[0], "f64": double.finish()[0], "peer": peer["found"]}
    error = {side: np.median(errors(of, rows, expected)) for side, of in found.items()}
    wall, processor = ({side: of[i] for side, of in medians.items()} for i in (0, 1))
    for precision in ("f32", "f64"):
        print(
            f"| {bodies} | {precision} | {error[precision]:.2e} | {error['peer']:.2e} | "
            f"{bodies / wall[precision] / 1000:.0f} | {bodies / wall['peer'] / 1000:.0f} | "
            f"{wall['peer'] / wall[precision]:.1f} | "
            f"{processor['peer'] / processor[precision]:.1f} | {others:.1f} |",
            flush=True,
        )


def main():
    given = arguments(__doc__, (100_000, 1_000_000))
    numba.set_num_threads(THREADS)
    print(
        "| bodies | law | its median error | pytreegrav's | law [1000 bodies/s] | "
        "pytreegrav [1000 bodies/s] | ratio | ratio of processor time | others' processors |\n"
        "|---:|---|---:|---:|---:|---:|---:|---:|---:|",
        flush=True,
    )
    for size in given.bodies:
        points = plummer(size)
        rows = np.random.default_rng(3).choice(size, 1000, replace=False)
        expected = exact(points, rows, SOFTENING)
        for case in CASES:
            compare(given, points, rows, expected, case)


if __name__ == "__main__":
    main()
