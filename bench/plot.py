#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws bench/results/speed.png from the tables in bench/results, and writes the README's table.

A bar is the speed of a row relative to its peer. The table contains the minimum and maximum of each
page. Needs Matplotlib.
"""

import harness
import pages

README = pages.RESULTS.parents[1] / "README.md"
MARKS = "<!-- from here on by bench/plot.py -->\n", "<!-- until here -->\n"

# Each row contains the page, the subject, the peer, the column of the ratio, the columns that name
# a row, and the rows to draw.
TABLES = [
    (
        "all_pairs.md",
        "gravitation of all pairs of 1,536 to 65,536 bodies",
        "{side}",
        "law's ratio",
        ["bodies", ""],
        lambda row: row["law's ratio"],
    ),
    (
        "barnes_hut.md",
        "gravitation by trees, 10⁵ and 10⁶ bodies",
        "pytreegrav",
        "ratio",
        ["bodies", "law", "its median error"],
        lambda row: True,
    ),
    (
        "springs.md",
        "10⁴ to 10⁶ springs",
        "a loop tuned for AVX-512",
        "ratio",
        ["springs", ""],
        lambda row: True,
    ),
    (
        "opencl.md",
        "gravitation on an OpenCL device",
        "the usual OpenCL kernel",
        "ratio",
        ["bodies"],
        lambda row: "bare kernel" in row["A, next to B"],
    ),
    (
        "spheres.md",
        "piles of 10,000 and 50,000 balls",
        "Jolt's rigid bodies",
        "times Jolt",
        ["balls", ""],
        lambda row: "Vesper" in row[""],
    ),
    (
        "bodies.md",
        "stacks, piles and a wall of boxes",
        "Jolt's rigid bodies",
        "times Jolt",
        ["scene"],
        lambda row: True,
    ),
    (
        "icosahedra.md",
        "a thousand icosahedra of springs",
        "Jolt's soft bodies",
        "times Jolt",
        [""],
        lambda row: "Vesper" in row[""],
    ),
    (
        "agents.md",
        "1 to 1,000 agents in lock-step: act, frame, perceive",
        "an echo in C (epoll)",
        "of epoll",
        ["agents", ""],
        lambda row: "REVE" in row[""],
    ),
]


def measured():
    """Yields page, subject, peer, name and ratio of each row to draw."""
    for file, subject, peer, column, names, drawn in TABLES:
        heading, rows = pages.read(file)
        for row in (dict(zip(heading, cells)) for cells in rows):
            if drawn(row):
                name = (
                    ", ".join(
                        f"{int(row[name]):,}" if row[name].isdigit() else row[name]
                        for name in names
                    )
                    .replace("Vesper, ", "")
                    .replace("REVE, ", "")
                )
                yield file, subject, peer.format(side=row.get("side")), name, float(row[column])


def draw(rows, picture):
    try:
        import matplotlib
    except ImportError:
        harness.fail(
            "Matplotlib is missing; install it with: sudo apt-get install python3-matplotlib"
        )
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    files = list(dict.fromkeys(file for file, *_ in rows))
    labels = [
        f"{file[:-3].replace('_', ' ')}: {name}\nnext to {peer}" for file, _, peer, name, _ in rows
    ]
    ratios = [ratio for *_, ratio in rows]
    figure, axes = plt.subplots(figsize=(9, 0.4 * len(rows) + 0.8), layout="constrained")
    bars = axes.barh(labels, ratios, color=[f"C{files.index(file)}" for file, *_ in rows])
    axes.bar_label(bars, [f"{ratio:g}×" for ratio in ratios], padding=3)
    axes.axvline(1, color="black", linewidth=1)
    axes.set_xscale("log")
    axes.set_xlim(0.2, 2 * max(ratios))
    axes.set_xticks([0.2, 0.5, 1, 2, 5, 10, 20], ["0.2", "0.5", "1", "2", "5", "10", "20"])
    axes.margins(y=0.01)
    axes.invert_yaxis()
    axes.set_xlabel("times as fast as the peer")
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=90)


def write_table(rows):
    found = {}
    for file, subject, peer, _, ratio in rows:
        found.setdefault((file, subject, peer), []).append(ratio)
    lines = ["| | next to | times as fast |\n", "|---|---|---:|\n"]
    for (file, subject, peer), ratios in found.items():
        lines.append(
            f"| [{subject}](bench/results/{file}) | {peer} | {min(ratios):g} to {max(ratios):g} |\n"
        )
    before, rest = README.read_text().split(MARKS[0])
    README.write_text("".join([before, MARKS[0], *lines, MARKS[1], rest.split(MARKS[1])[1]]))


def main():
    options = harness.arguments(__doc__, "draws build/bench/speed.png and leaves the README")
    chosen = options.parse_args()
    rows = list(measured())
    picture = (harness.OUT if chosen.quick else pages.RESULTS) / "speed.png"
    draw(rows, picture)
    print(picture)
    if not chosen.quick:
        write_table(rows)


if __name__ == "__main__":
    main()
