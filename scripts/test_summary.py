# SPDX-License-Identifier: Apache-2.0
"""Adds up JUnit reports; the last line is `N passed, N failed`.

    test_summary.py FOLDER ROOM...

Each ROOM is a report FOLDER/ROOM.xml or a folder of reports FOLDER/ROOM/. A room without any test
in a report counts as one failure, because a failed build must not count as passed. So does a report
that is cut.
"""

import sys
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path


@dataclass
class Case:
    """One test case; `part` is the argument of `./reve test ROOM/PART` that runs it alone. It is
    empty if only the whole room can be run again."""

    name: str
    part: str
    outcome: str
    text: str


def cases(room):
    """Yields the test cases in a room's reports, and a failed one for each report that is cut."""
    reports = sorted(room.rglob("*.xml")) if room.is_dir() else [room.with_suffix(".xml")]
    for report in reports:
        if report.exists():
            try:
                for _, element in ET.iterparse(report):
                    if element.tag == "testcase":
                        yield case(element)
            except ET.ParseError as error:
                yield Case(report.name, "", "failed", f"{report} is cut: {error}")


def case(element):
    name, owner, file = (element.get(key, "") for key in ("name", "classname", "file"))
    if file.endswith(".py"):  # pytest
        # The names of classes, if there are any, follow the name of the module.
        inside = [piece for piece in owner.split(".")[1:] if piece]
        full, part = f"{file}::{name}", "::".join([file, *inside, name.split("[")[0]])
    elif file:  # GoogleTest
        full = part = f"{owner}.{name}"
    elif not owner or owner == name:  # ctest
        full = part = name
    else:  # JUnit: CLASS and METHOD(PARAMETERS)[NUMBER]
        full = f"{owner}.{name}"
        part = f"{owner.split('.')[-1].split('$')[0]}#{name.split('(')[0]}"
    part = element.get("part", part)  # of a suite that ended badly, see run_tests.py
    bad = [child for child in element if child.tag in ("failure", "error")]
    if bad:
        # ctest reports only that a test failed; the output of the test contains the reason.
        said = bad if owner and owner != name else [*bad, *element.iter("system-out")]
        text = "\n".join((e.get("message") or "") + "\n" + (e.text or "") for e in said)
        return Case(full, part, "failed", text.strip())
    if any(child.tag == "skipped" for child in element):
        return Case(full, part, "skipped", "")
    return Case(full, part, "passed", "")


def report(folder, rooms):
    """Prints each failed test, a line for each room, and the sum; returns the exit status."""
    total = {"passed": 0, "failed": 0, "skipped": 0}
    for room in rooms:
        count = dict.fromkeys(total, 0)
        for test in cases(folder / room):
            count[test.outcome] += 1
            if test.outcome == "failed":
                print(f"\nFAILED {room}: {test.name}")
                print("\n".join("    " + line for line in test.text.splitlines()[:30]))
                again = f"{room}/{test.part}" if test.part else room
                print(f"    To run it alone: ./reve test '{again}'")
        if count["passed"] + count["failed"] == 0:
            print(f"\nFAILED {room}: no test ran (see the output above)")
            count["failed"] = 1
        print(
            f"{room:20} {count['passed']:5} passed {count['failed']:4} failed"
            f" {count['skipped']:4} skipped"
        )
        for key in total:
            total[key] += count[key]
    skipped = f", {total['skipped']} skipped" if total["skipped"] else ""
    print(f"{total['passed']} passed, {total['failed']} failed{skipped}")
    return 1 if total["failed"] else 0


if __name__ == "__main__":
    sys.exit(report(Path(sys.argv[1]), sys.argv[2:]))
