"""Adds up JUnit reports and prints, last, `N passed, N failed`.

    test_summary.py FOLDER SUITE...

Each SUITE is a report FOLDER/SUITE.xml or a folder of reports FOLDER/SUITE/. A suite that left no
test in a report counts as one failure: a build that broke must not read as passed.
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path


def cases(suite):
    """Yields (name, outcome, text) of each test case in a suite's reports."""
    reports = sorted(suite.glob("*.xml")) if suite.is_dir() else [suite.with_suffix(".xml")]
    for report in reports:
        if not report.exists():
            continue
        for case in ET.parse(report).getroot().iter("testcase"):
            name = ".".join(filter(None, (case.get("classname"), case.get("name"))))
            bad = [e for e in case if e.tag in ("failure", "error")]
            if bad:
                text = "\n".join((e.get("message") or "") + "\n" + (e.text or "") for e in bad)
                yield name, "failed", text.strip()
            elif any(e.tag == "skipped" for e in case):
                yield name, "skipped", ""
            else:
                yield name, "passed", ""


def main():
    folder, suites = Path(sys.argv[1]), sys.argv[2:]
    total = {"passed": 0, "failed": 0, "skipped": 0}
    for name in suites:
        count = dict.fromkeys(total, 0)
        for test, outcome, text in cases(folder / name):
            count[outcome] += 1
            if outcome == "failed":
                print(f"\nFAILED {name}: {test}")
                print("\n".join("    " + line for line in text.splitlines()[:30]))
        if count["passed"] + count["failed"] == 0:
            print(f"\nFAILED {name}: no test ran (see the output above)")
            count["failed"] = 1
        print(f"{name:18} {count['passed']:5} passed {count['failed']:4} failed"
              f" {count['skipped']:4} skipped")
        for key in total:
            total[key] += count[key]
    skipped = f", {total['skipped']} skipped" if total["skipped"] else ""
    print(f"{total['passed']} passed, {total['failed']} failed{skipped}")
    return 1 if total["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
