# SPDX-License-Identifier: Apache-2.0
"""The pages in bench/results: a heading, where and by what it was measured, and a table."""

import os
import platform
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def table(text):
    """The table in a text: the cells of its heading, and of its rows."""
    lines = [cells(line) for line in text.splitlines() if line.startswith("|")]
    return (lines[0], lines[2:]) if lines else ([], [])


def read(file):
    """The table of a page."""
    return table((RESULTS / file).read_text())


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return f"{line.split(': ')[1]}, {os.cpu_count()} cores visible"
    return f"{platform.machine()}, {os.cpu_count()} cores visible"


def write(file, title, script, text, note=""):
    """Writes a page with the table in `text`. Rows of the page that is there stay, if they were
    measured on the same processor, have the same columns and their first cell is not in the new
    table: so sizes can be measured one at a time. These first cells are numbers."""
    page = RESULTS / file
    heading, rows = table(text)
    about = f"CPU: {cpu()}.{note}"
    if page.exists() and about in page.read_text():
        old_heading, old_rows = read(file)
        measured = {row[0] for row in rows}
        if old_heading == heading:
            rows += [row for row in old_rows if row[0] not in measured]
            rows.sort(key=lambda row: float(row[0]))
    names = text.splitlines()[:2]
    RESULTS.mkdir(exist_ok=True)
    page.write_text(
        "\n".join(
            [
                f"# {title}",
                "",
                f"Written by `{script}`; what the figures mean stands in "
                "[docs/benchmarks.md](../../docs/benchmarks.md).",
                "",
                about,
                "",
                *names,
                *(f"| {' | '.join(row)} |" for row in rows),
                "",
            ]
        )
    )
    print(page.read_text())
