"""Runs the unittest suites below a folder and writes a JUnit report.

    python_tests.py FOLDER REPORT.xml
"""

import sys
import unittest
import xml.etree.ElementTree as ET


class Recorder(unittest.TextTestResult):
    """Keeps one (test id, outcome, text) per test, sub-tests counted with their test."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.outcomes = {}

    def startTest(self, test):
        super().startTest(test)
        self.outcomes[test.id()] = ("passed", "")

    def addError(self, test, err):
        super().addError(test, err)
        self.outcomes[test.id()] = ("failed", self._exc_info_to_string(err, test))

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.outcomes[test.id()] = ("failed", self._exc_info_to_string(err, test))

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self.outcomes[test.id()] = ("failed", self._exc_info_to_string(err, test))

    def addUnexpectedSuccess(self, test):
        super().addUnexpectedSuccess(test)
        self.outcomes[test.id()] = ("failed", "expected to fail, but passed")

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.outcomes[test.id()] = ("skipped", reason)


def write_report(outcomes, path):
    suite = ET.Element("testsuite", name="python")
    for test_id, (outcome, text) in outcomes.items():
        case = ET.SubElement(suite, "testcase", name=test_id)
        if outcome == "failed":
            ET.SubElement(case, "failure").text = text
        elif outcome == "skipped":
            ET.SubElement(case, "skipped").text = text
    ET.ElementTree(suite).write(path, encoding="utf-8", xml_declaration=True)


def main():
    folder, report = sys.argv[1:]
    suite = unittest.defaultTestLoader.discover(folder, top_level_dir=folder)
    result = unittest.TextTestRunner(resultclass=Recorder, verbosity=1).run(suite)
    write_report(result.outcomes, report)
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
