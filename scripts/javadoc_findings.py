# SPDX-License-Identifier: Apache-2.0
"""Prints the output of javadoc without the warnings that this project ignores.

    gradle javadoc 2>&1 | javadoc_findings.py ROOT

The script ignores warnings about missing tags for results, exceptions and parameters, because a
sentence may describe these. Exits with 1 if another warning remains: a comment is missing or
broken.
"""

import re
import sys

WARNING = re.compile(r"^(?P<place>.+?:\d+): warning: (?P<text>.*)$")
UNHEEDED = re.compile(
    r"no (@param|@return|@throws) |no @return$|no main description$|use of default constructor"
)
COUNT = re.compile(r"^[\d,]+ warnings?$")
# Number of lines that belong to a warning: the source line, and the line that marks the position.
LINES_BELOW = 2


def findings(lines):
    """Yields the lines to show, each with a flag that is true for a warning."""
    skip = 0
    for line in lines:
        warning = WARNING.match(line)
        if warning:
            heeded = UNHEEDED.match(warning["text"]) is None
            skip = 0 if heeded else LINES_BELOW
            if heeded:
                yield line, True
        elif skip > 0:
            skip -= 1
        elif line and not COUNT.match(line):
            yield line, False


def main():
    root = sys.argv[1] + "/"
    found = 0
    for line, is_warning in findings(line.rstrip("\n") for line in sys.stdin):
        found += is_warning
        print(line.replace(root, ""), flush=True)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
