# SPDX-License-Identifier: Apache-2.0
"""Pages in bench/results: a heading, machine and command of the measurement, and a table."""

import os
import platform
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def table(text):
    """Returns the table in a text: the cells of its heading, and those of its rows."""
    lines = [cells(line) for line in text.splitlines() if line.startswith("|")]
    return (lines[0], lines[2:]) if lines else ([], [])


def read(file):
    """Returns the table of a page."""
    return table((RESULTS / file).read_text())


def cpu():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return f"{line.split(': ')[1]}, {os.cpu_count()} cores visible"
    return f"{platform.machine()}, {os.cpu_count()} cores visible"


def for_processor(name):
    """Returns the file of a page that exists once for AMD and once for Intel processors."""
    return f"{name}_intel.md" if "Intel" in cpu() else f"{name}.md"


def show(text):
    """Prints the table of a short form, which is not stored as a result."""
    print(text.rstrip("\n"))
    print("\nThese are figures of the short form; no page was written.")


def put(file, text):
    """Writes a whole page and prints it."""
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / file).write_text(text)
    print(text)


def write(file, title, script, text, note=""):
    """Writes a page with the table in `text`.

    If the existing page was measured on the same processor and has the same columns, keeps some of
    its rows: those whose first cell, a number, is in no row of the new table. Different sizes can
    therefore be measured separately.
    """
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
    put(
        file,
        "\n".join(
            [
                f"# {title}",
                "",
                f"Written by `{script}`. [docs/benchmarks.md](../../docs/benchmarks.md) explains the "
                "figures.",
                "",
                about,
                "",
                *names,
                *(f"| {' | '.join(row)} |" for row in rows),
                "",
            ]
        ),
    )
