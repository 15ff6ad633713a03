#!/usr/bin/env python3
"""Draws bench/results/speed.png from the tables in bench/results: how many times as fast as the peer
each row is. Needs Matplotlib (Debian: python3-matplotlib)."""
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

RESULTS = pathlib.Path(__file__).parent / "results"
# Table, what it is compared with, column of the ratio, columns that name a row.
TABLES = [
    ("all_pairs.md", "a kernel tuned for AVX-512", "ratio of processor time", [0, 1]),
    ("barnes_hut.md", "pytreegrav", "ratio of processor time", [0, 1, 2]),
    ("springs.md", "a loop tuned for AVX-512", "ratio of processor time", [0, 1]),
    ("opencl.md", "the usual OpenCL kernel", "ratio of processor time", [0, 1]),
    ("spheres.md", "Jolt's rigid bodies", "times Jolt", [0]),
    ("icosahedra.md", "Jolt's soft bodies", "times Jolt", [0]),
]


def rows(file):
    """The table of a page: a dictionary for each row, from the heading of a column to its cell."""
    lines = [line for line in (RESULTS / file).read_text().splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return cells[0], cells[2:]


def main():
    labels, ratios, colours = [], [], []
    for number, (file, peer, column, names) in enumerate(TABLES):
        heading, body = rows(file)
        for row in body:
            ratio = float(row[heading.index(column)])
            if "Jolt (" in row[0] or "soft bodies (" in row[0] or "next to `opencl_nbody`" in row[1]:
                continue
            name = ", ".join(row[i].replace("`", "").split(", next to")[0] for i in names)
            labels.append(f"{file[:-3].replace('_', ' ')}: {name}\nnext to {peer}")
            ratios.append(ratio)
            colours.append(f"C{number}")
    figure, axes = plt.subplots(figsize=(9, 0.5 * len(labels) + 0.8), layout="constrained")
    bars = axes.barh(labels, ratios, color=colours)
    axes.bar_label(bars, [f"{ratio:g}×" for ratio in ratios], padding=3)
    axes.axvline(1, color="black", linewidth=1)
    axes.set_xscale("log")
    axes.set_xlim(0.5, 2 * max(ratios))
    axes.set_xticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"])
    axes.invert_yaxis()
    axes.set_xlabel("times as fast as the peer, by processor time")
    figure.savefig(RESULTS / "speed.png", dpi=90)


if __name__ == "__main__":
    main()
