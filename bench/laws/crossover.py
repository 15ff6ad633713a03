# SPDX-License-Identifier: Apache-2.0
"""Compares barnes_hut_gravitation with newton_gravitation, in turn, from few bodies to many.

Prints a table; see docs/benchmarks.md.
"""

from barnes_hut import SOFTENING, plummer
from sides import Program, arguments, in_turn, rounds

SIZES = (1000, 3000, 5000, 7000, 10_000, 30_000, 100_000, 300_000, 1_000_000)
# Maximum number of bodies in f64. A step over all pairs of more bodies takes minutes.
MOST_IN_DOUBLE = 300_000


def compare(given, points, precision):
    bodies = len(points)
    with Program(
        given, precision, SOFTENING, points, "barnes_hut_gravitation", "newton_gravitation"
    ) as ours:
        sides = {"tree": ours.side(0), "pairs": ours.side(1)}
        medians, others = in_turn(sides, **rounds(given, 9 if bodies < 100_000 else 1))
    (tree, tree_processor), (pairs, pairs_processor) = medians["tree"], medians["pairs"]
    print(
        f"| {bodies} | {precision} | {1000 * tree:.3g} | {1000 * pairs:.3g} | "
        f"{pairs / tree:.2f} | {pairs_processor / tree_processor:.2f} | {others:.1f} |",
        flush=True,
    )


def main():
    given = arguments(__doc__, SIZES)
    print(
        "| bodies | | barnes_hut_gravitation [ms/step] | newton_gravitation [ms/step] | ratio | "
        "ratio of processor time | others' processors |\n"
        "|---:|---|---:|---:|---:|---:|---:|",
        flush=True,
    )
    for size in given.bodies:
        points = plummer(size)
        for precision in ("f32", "f64"):
            if precision == "f32" or size <= MOST_IN_DOUBLE:
                compare(given, points, precision)


if __name__ == "__main__":
    main()
