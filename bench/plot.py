#!/usr/bin/env python3
"""Draws bench/results/speed.png from the tables in bench/results: how many times as fast as the
peer a row is. Needs Matplotlib (Debian: python3-matplotlib)."""
import matplotlib

import pages

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# Page, what it is compared with, column of the ratio, columns that name a row, rows that are drawn.
TABLES = [
    ("all_pairs.md", "{side}", "law's ratio", ["bodies", ""], lambda row: row["law's ratio"]),
    ("barnes_hut.md", "pytreegrav", "ratio", ["bodies", "law", "its median error"],
     lambda row: True),
    ("springs.md", "a loop tuned for AVX-512", "ratio", ["springs", ""],
     lambda row: True),
    ("opencl.md", "the usual OpenCL kernel", "ratio", ["bodies"],
     lambda row: "bare kernel" in row["A, next to B"]),
    ("spheres.md", "Jolt's rigid bodies", "times Jolt", ["balls", ""],
     lambda row: "Vesper" in row[""]),
    ("icosahedra.md", "Jolt's soft bodies", "times Jolt", [""], lambda row: "Vesper" in row[""]),
]


def main():
    labels, ratios, colours = [], [], []
    for number, (file, peer, column, names, drawn) in enumerate(TABLES):
        heading, rows = pages.read(file)
        for cells in rows:
            row = dict(zip(heading, cells))
            if not drawn(row):
                continue
            name = ", ".join(f"{int(row[name]):,}" if row[name].isdigit() else row[name]
                             for name in names).replace("Vesper, ", "")
            labels.append(f"{file[:-3].replace('_', ' ')}: {name}\n"
                          f"next to {peer.format(side=row.get('side'))}")
            ratios.append(float(row[column]))
            colours.append(f"C{number}")
    figure, axes = plt.subplots(figsize=(9, 0.4 * len(labels) + 0.8), layout="constrained")
    bars = axes.barh(labels, ratios, color=colours)
    axes.bar_label(bars, [f"{ratio:g}×" for ratio in ratios], padding=3)
    axes.axvline(1, color="black", linewidth=1)
    axes.set_xscale("log")
    axes.set_xlim(0.5, 2 * max(ratios))
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])
    axes.margins(y=0.01)
    axes.invert_yaxis()
    axes.set_xlabel("times as fast as the peer")
    figure.savefig(pages.RESULTS / "speed.png", dpi=90)


if __name__ == "__main__":
    main()
