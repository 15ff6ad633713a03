# SPDX-License-Identifier: Apache-2.0
"""barnes_hut_gravitation next to newton_gravitation, in turn, from few bodies to many.

usage: crossover.py BENCH_PROGRAM FOLDER_OF_LAWS [BODIES...]
Prints a table; see docs/benchmarks.md.
"""

import sys

from barnes_hut import SOFTENING, plummer
from sides import Program, in_turn

SIZES = (1000, 3000, 5000, 7000, 10_000, 30_000, 100_000, 300_000, 1_000_000)
# Beyond it a step of all pairs in f64 takes minutes.
MOST_IN_DOUBLE = 300_000


def compare(program, laws, points, precision):
    bodies = len(points)
    with Program(
        program, laws, precision, SOFTENING, points, "barnes_hut_gravitation", "newton_gravitation"
    ) as ours:
        sides = {"tree": ours.side(0), "pairs": ours.side(1)}
        medians, others = in_turn(sides, rounds=9 if bodies < 100_000 else 1)
    (tree, tree_processor), (pairs, pairs_processor) = medians["tree"], medians["pairs"]
    print(
        f"| {bodies} | {precision} | {1000 * tree:.3g} | {1000 * pairs:.3g} | "
        f"{pairs / tree:.2f} | {pairs_processor / tree_processor:.2f} | {others:.1f} |",
        flush=True,
    )


def main():
    program, laws, *sizes = sys.argv[1:]
    print(
        "| bodies | | barnes_hut_gravitation [ms/step] | newton_gravitation [ms/step] | ratio | "
        "ratio of processor time | others' processors |\n"
        "|---:|---|---:|---:|---:|---:|---:|",
        flush=True,
    )
    for size in map(int, sizes or SIZES):
        points = plummer(size)
        for precision in ("f32", "f64"):
            if precision == "f32" or size <= MOST_IN_DOUBLE:
                compare(program, laws, points, precision)


if __name__ == "__main__":
    main()
