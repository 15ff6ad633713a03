# SPDX-License-Identifier: Apache-2.0
"""Compares newton_gravitation in the engine with a bare kernel, Numba and REBOUND, in turn.

Prints a table; see docs/benchmarks.md.
"""

import numba
import numpy as np
import rebound
from sides import THREADS, Program, arguments, attract, errors, exact, in_turn, rounds, timed

SOFTENING = 0.01
LAWS = {"law": "newton_gravitation", "law, fast": "newton_gravitation fast=1"}
KERNEL = "kernel for AVX-512"
# Maximum number of bodies for REBOUND. A step with more bodies takes minutes.
MOST_FOR_REBOUND = 16384


def numba_side(points):
    columns = [np.ascontiguousarray(points[:, c]) for c in range(3)]
    columns.append(np.full(len(points), 1 / len(points), points.dtype))
    result = [np.zeros_like(columns[0]) for _ in range(3)]
    softening2 = points.dtype.type(SOFTENING**2)
    return timed(lambda: attract(*columns, *result, softening2)), lambda: np.stack(result, axis=1)


def rebound_side(points):
    simulation = rebound.Simulation()
    simulation.gravity, simulation.integrator = "basic", "leapfrog"
    simulation.softening, simulation.dt = SOFTENING, 1e-12
    for x, y, z in points:
        simulation.add(m=1 / len(points), x=x, y=y, z=z)
    return (
        timed(lambda: simulation.steps(1)),
        lambda: np.array([(p.ax, p.ay, p.az) for p in simulation.particles]),
    )


def compare(given, bodies, precision):
    real = {"f32": np.float32, "f64": np.float64}[precision]
    points = np.random.default_rng(1).uniform(-1, 1, (bodies, 3)).astype(real)
    names = [*LAWS, KERNEL]
    peers = {"Numba": numba_side(points)}
    if precision == "f64" and bodies <= MOST_FOR_REBOUND:
        peers["REBOUND, 1 thread"] = rebound_side(points)
    with Program(given, precision, SOFTENING, points, *LAWS.values(), "kernel") as ours:
        sides = {name: ours.side(k) for k, name in enumerate(names)}
        sides |= {name: run for name, (run, _) in peers.items()}
        medians, others = in_turn(sides, **rounds(given, 5))
        found = dict(zip(names, ours.finish())) | {name: get() for name, (_, get) in peers.items()}
    rows = np.random.default_rng(3).choice(bodies, 100, replace=False)
    expected = exact(points, rows, SOFTENING, np.longdouble)
    for name, (wall, processor) in medians.items():
        error = np.sqrt(np.mean(errors(found[name], rows, expected) ** 2))
        ratios = [
            " | ".join(
                "" if name in LAWS else f"{of / medians[law][i]:.2f}"
                for i, of in enumerate((wall, processor))
            )
            for law in LAWS
        ]
        print(
            f"| {bodies} | {precision} | {name} | {1 / wall:.{0 if wall < 0.1 else 2}f} | "
            f"{1e-9 * bodies**2 / wall:.2f} | {error:.1e} | {' | '.join(ratios)} | "
            f"{others:.1f} |",
            flush=True,
        )


def main():
    given = arguments(__doc__, (1536, 16384, 65536))
    numba.set_num_threads(THREADS)
    print(
        "| bodies | | side | steps/s | 10^9 interactions/s | error | law's ratio | "
        "of processor time | fast law's ratio | fast, of processor time | others' processors |\n"
        "|---:|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
        flush=True,
    )
    for size in given.bodies:
        for precision in ("f32", "f64"):
            compare(given, size, precision)


if __name__ == "__main__":
    main()
