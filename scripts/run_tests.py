# SPDX-License-Identifier: Apache-2.0
"""Runs the tests of rooms, four suites at a time; the last line is `N passed, N failed`.

    run_tests.py ROOT [--quick] [--failed] [ROOM[/PART] ...]

`./reve test` calls this script after the build; without rooms it runs all of them. A PART selects
tests of a room: in Java, a project of the room, a part of a class name, CLASS#METHOD, or
PROJECT/CLASS; in the native rooms, a part of a test's name or the folder of a law; in Python, a
file, or FILE::CLASS::TEST. --quick skips slow tests (`slow` below); --failed repeats the tests that
failed in the last run. JUnit reports are in build/reports/tests, one folder for each room or
project, with the output of each program beside them. times.csv in this folder says what
each suite cost.
"""

import argparse
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

import test_summary

JAVA_ROOMS = ["reve-core", "reve-pe-adapter", "reve-worlds", "agents-java", "tests"]
# Rooms that consist of several Gradle projects. Each project has its own class path, and its tests
# run in a separate JVM.
PROJECTS = {
    "reve-core": ["world", "files", "agents"],
    "reve-worlds": ["runtime", "web", "cluster", "app"],
}
NATIVE_ROOMS = {"vesper-native": "build/native", "laws": "build/native/laws-build"}
ROOMS = [*NATIVE_ROOMS, *JAVA_ROOMS, "python", "format"]

# Tests that --quick skips. In Java and Python the tests are marked: @Tag("slow"), mark slow.
SLOW_NATIVE = "opencl|OpenCl|OnADevice|NBodyWorld|/threads"
SLOW_CONTRACT = ["opencl"]

# The classes of these rooms start servers and wait for them. They are divided into this number of
# batches, which several JVMs run concurrently.
BATCHED = {"tests": 12}

# These classes wait for minutes for what they do not compute themselves, such as the end of a lease.
# One suite runs them beside all others, from the start.
WAITING = ["ClusterPartitionIT", "ClusterFaultIT", "ClusterUpgradeIT", "ClusterIT"]

# The classes that take longest come first, so that each is in another batch.
SLOWEST = ["StoreIT", "PageIT", "DiskFaultIT", "EngineProcessIT", "RunningWorldsIT", "ReconnectIT"]
SLOWEST += [
    "OutputIT",
    "ReleasesIT",
    "LawsInPythonIT",
    "CommandLineIT",
    "ApiPagesIT",
    "WritingALawIT",
]

# Rooms whose tests take minutes and are not divided into batches.
LONG = {"laws", "python"}

# Option of a JVM that lives for seconds: the commands and servers that tests start, and the
# batches. The second compiler would take half of the processor time of such a JVM without making it
# faster.
SHORT_LIVED = "-XX:TieredStopAtLevel=1"
SHORT_LIVES = {"REVE_JAVA_OPTIONS": SHORT_LIVED}

# Rooms whose tests take a third less processor time without the second compiler.
FIRST_COMPILER = {"reve-core/world", "reve-core/files", "reve-core/agents"}

# Number of suites that run at the same time. It may exceed the number of processors, because many
# tests wait for servers.
AT_ONCE = 4
PROGRESS_SECONDS = 20

# A process that a test left behind may hold the pipe of a suite's output. After the end of the suite
# itself, its output is read for this time at most.
DRAIN_SECONDS = 60
LAST_LINES = 20  # of the output of a suite that ended badly

BUILD = "build of the tests"  # named in the summary if it failed

# Pattern of a line that reports a finished test. It matches the lines of ctest, GoogleTest, JUnit's
# feed and pytest.
ENDED = re.compile(
    r"^\s*\d+/\d+ Test +#\d+: .*?(?P<ctest>Passed|\*\*\*\w+)"
    r"|^\[ +(?P<googletest>OK|FAILED|SKIPPED) +\] .* \(\d+ ms\)$"
    r"|:: (?P<junit>SUCCESSFUL|FAILED|SKIPPED)\s*$"
    r"|^\S+\.py::.* (?P<pytest>PASSED|FAILED|SKIPPED|ERROR)\b"
)
GOOD = {"Passed", "OK", "SUCCESSFUL", "PASSED", "SKIPPED", "***Skipped"}


@dataclass
class Suite:
    """One test program: its command, the report that it writes, the file of its output, and its
    finished tests so far."""

    name: str
    command: list
    report: Path
    log: Path
    environment: dict = field(default_factory=dict)
    ended: int = 0
    failed: int = 0
    seconds: float = 0  # from start to end
    processor_seconds: float = 0  # of its process and of all processes that it waited for


class Plan:
    """Creates the suites of the selected rooms."""

    def __init__(self, root, quick):
        self.root = root
        self.reports = root / "build/reports/tests"
        self.quick = quick

    def suites(self, room, parts):
        if room == "laws":
            return [self.contract(parts), self.native(room, parts)]
        if room in NATIVE_ROOMS:
            return [self.native(room, parts)]
        if room == "python":
            return [self.python(parts)]
        if room == "format":
            return [
                self.suite(
                    room,
                    room,
                    [
                        "python3",
                        self.root / "scripts/format.py",
                        self.root,
                        "--check",
                        "--report",
                        self.reports / room / "format.xml",
                    ],
                    self.reports / room / "format.xml",
                )
            ]
        return list(self.java(room, parts))

    def suite(self, room, name, command, report, **environment):
        log = self.reports / room / f"{name}.log"
        return Suite(name, [str(c) for c in command], report, log, environment)

    def native(self, room, parts):
        report = self.reports / room / "ctest.xml"
        command = [
            "ctest",
            "--test-dir",
            self.root / NATIVE_ROOMS[room],
            "--output-on-failure",
            "--output-junit",
            report,
        ]
        if parts:
            command += ["-R", "|".join(map(re.escape, native_names(parts)))]
        excluded = ["^LawContract$"]  # runs as a suite of its own
        if self.quick:
            excluded.append(SLOW_NATIVE)
        command += ["-E", "|".join(excluded)]
        return self.suite(room, room, command, report)

    def contract(self, parts):
        """The contract of all laws. One process runs all its checks, because the start of a process
        for each check, as in ctest, takes about 10 ms."""
        chosen = [f"*{name}*" for name in native_names(parts)] or ["*"]
        left_out = [f"*{name}*" for name in SLOW_CONTRACT] if self.quick else []
        report = self.reports / "laws/contract.xml"
        command = [
            self.root / NATIVE_ROOMS["laws"] / "law-contract/law_contract_test",
            "--gtest_color=no",
            f"--gtest_output=xml:{report}",
            f"--gtest_filter={':'.join(chosen)}-{':'.join(left_out)}",
        ]
        return self.suite("laws", "law-contract", command, report)

    def python(self, parts):
        tests = self.root / "agents/python/tests"
        report = self.reports / "python/pytest.xml"
        command = [
            os.environ["REVE_TEST_PYTHON"],
            "-m",
            "pytest",
            "-v",
            "--tb=short",
            "-p",
            "no:cacheprovider",
            "--color=no",
            f"--junitxml={report}",
            "-o",
            "junit_family=xunit1",
            "-o",
            f"pythonpath={tests.parent}",
            "-o",
            "markers=slow: left out by --quick",
            f"--rootdir={tests}",
        ]
        if self.quick:
            command += ["-m", "not slow"]
        command += [tests / part for part in parts] or [tests]
        return self.suite(
            "python",
            "python",
            command,
            report,
            REVE_ROOT=str(self.root),
            REVE_TEST_CLASSPATH=f"{self.root}/build/stage/lib/*",
            **SHORT_LIVES,
        )

    def places(self, room, parts):
        """Yields the places where tests of a room run: the room itself, or its projects with such
        tests. Yields each place with the parts that select tests there."""
        if room not in PROJECTS:
            yield room, parts
            return
        found = False
        for project in PROJECTS[room]:
            place = f"{room}/{project}"
            if not parts or project in parts:
                found = True
                yield place, []
                continue
            narrow = [
                part.removeprefix(f"{project}/") for part in parts if part not in PROJECTS[room]
            ]
            if narrow and (not self.listing(place).exists() or self.classes(place, narrow)[0]):
                found = True
                yield place, narrow
        if not found:
            yield room, parts

    def listing(self, place):
        return self.root / "build/test-class-paths" / f"{place.replace('/', '-')}.txt"

    def classes(self, place, parts):
        """Returns the names of the test classes that parts select, and their class path."""
        folder, class_path = self.listing(place).read_text().splitlines()
        classes = sorted(
            str(path.relative_to(folder))[: -len(".class")].replace("/", ".")
            for path in Path(folder).rglob("*.class")
            if re.fullmatch(r"[^$]*(Test|IT)\.class", path.name)
        )
        if parts:
            wanted = [part.split("#")[0].replace("/", ".") for part in parts]
            classes = [name for name in classes if any(part in name for part in wanted)]
        return classes, class_path

    def java(self, place, parts):
        if place not in PROJECTS and not self.listing(place).exists():
            print(
                f"reve: the tests of {place} could not be built; see the first error above",
                file=sys.stderr,
            )
            return
        classes, class_path = ([], "") if place in PROJECTS else self.classes(place, parts)
        if not classes:
            print(
                f"reve: {place} has no test class with {' or '.join(parts)} in its name",
                file=sys.stderr,
            )
            return
        base = place.replace("/", "-")
        waiting = [one for one in classes if simple_name(one) in WAITING]
        others = sorted((one for one in classes if one not in waiting), key=order)
        count = min(BATCHED.get(place, 1), len(others))
        batches = {f"{base}-waiting": waiting} if waiting else {}
        for number in range(count):
            batches[base if count == 1 else f"{base}-{number + 1}"] = others[number::count]
        for name, batch in batches.items():
            report = self.reports / place / name / "TEST-junit-jupiter.xml"
            command = [
                os.environ["REVE_JAVA_HOME"] + "/bin/java",
                "-XX:+UseSerialGC",  # as in a release; needs less processor time than G1
                *([SHORT_LIVED] if place in BATCHED or place in FIRST_COMPILER else []),
                "-ea",
                "--enable-native-access=ALL-UNNAMED",
                "-XX:+RestoreMXCSROnJNICalls",
                # The libraries msgpack-core and protobuf, which CEL uses, require this option.
                "--sun-misc-unsafe-memory-access=allow",
                "-Dreve.check.thread=true",
                f"-Dreve.native.path={self.root}/build/native",
                f"-Dreve.root={self.root}",
                "-cp",
                class_path,
                "org.junit.platform.console.ConsoleLauncher",
                "execute",
                "--disable-banner",
                "--disable-ansi-colors",
                "--details=testfeed",
                f"--reports-dir={report.parent}",
            ]
            if any("#" in part for part in parts):
                command += [f"--include-methodname={method_pattern(part)}" for part in parts]
            if self.quick:
                command.append("--exclude-tag=slow")
            command += [f"--select-class={c}" for c in batch]
            more = SHORT_LIVES | patient_python(self.root) if place in BATCHED else {}
            yield self.suite(place, name, command, report, **more)


def patient_python(root):
    """Makes a program `python3` that lets clients of `reve` wait longer, see the folder `patient`
    of the tests in Python. Returns the environment in which tests and their programs find it."""
    patient = root / "agents/python/tests/patient"
    program = root / "build/patient/python3"
    program.parent.mkdir(exist_ok=True)
    path = f'"{patient}${{PYTHONPATH:+:$PYTHONPATH}}"'
    program.write_text(f'#!/bin/sh\nPYTHONPATH={path} exec "{sys.executable}" "$@"\n')
    program.chmod(0o755)
    return {"PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"}


def native_names(parts):
    """Returns what the names of native tests contain: the tests of the law hooke_spring are named
    HookeSpring...."""
    camel = [
        re.sub(r"(?:^|_)(\w)", lambda found: found[1].upper(), part)
        for part in parts
        if re.fullmatch("[a-z0-9_]+", part)
    ]
    return [*parts, *camel]


def simple_name(class_name):
    return class_name.rpartition(".")[2]


def order(class_name):
    """Returns the place of a class: those of SLOWEST in their order, then all others."""
    name = simple_name(class_name)
    return SLOWEST.index(name) if name in SLOWEST else len(SLOWEST)


def method_pattern(part):
    """Returns a pattern for JUnit's names: CLASS#METHOD, or CLASS#METHOD(PARAMETERS)."""
    name, _, method = part.replace("/", ".").partition("#")
    return f".*{re.escape(name)}.*#{re.escape(method)}" + (r"(\(.*)?" if method else ".*")


class Runner:
    """Runs suites on their own threads and prints the progress to stderr."""

    def __init__(self, suites):
        self.waiting = queue.SimpleQueue()
        for suite in suites:
            self.waiting.put(suite)
        self.suites = suites
        self.running = []
        self.started = time.monotonic()
        self.lock = threading.Lock()

    def run(self):
        threads = [threading.Thread(target=self.work) for _ in range(AT_ONCE)]
        for thread in threads:
            thread.start()
        for thread in threads:
            while thread.is_alive():
                thread.join(PROGRESS_SECONDS)
                self.tell()

    def work(self):
        while True:
            try:
                suite = self.waiting.get_nowait()
            except queue.Empty:
                return
            with self.lock:
                self.running.append(suite.name)
            started = time.monotonic()
            try:
                end = self.execute(suite)
            except OSError as error:  # for example, its program was not built
                end = f"cannot be started: {error}"
            suite.seconds = time.monotonic() - started
            report_end(suite, end)
            with self.lock:
                self.running.remove(suite.name)

    def execute(self, suite):
        """Runs a suite to its end; returns how it ended, or "" for exit status 0."""
        process = subprocess.Popen(
            suite.command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            errors="replace",
            env=os.environ | suite.environment,
        )
        reader = threading.Thread(target=read_output, args=(suite, process.stdout), daemon=True)
        reader.start()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        suite.processor_seconds = usage.ru_utime + usage.ru_stime
        reader.join(DRAIN_SECONDS)
        if reader.is_alive():
            with suite.log.open("a") as log:
                for one in holders(process.stdout):
                    print(f"reve: left behind by {suite.name}: {one}", file=log)
        code = process.returncode
        if code < 0:
            return f"ended by signal {-code} ({signal.strsignal(-code)})"
        return f"ended with exit status {code}" if code else ""

    def tell(self):
        seconds = int(time.monotonic() - self.started)
        ended = sum(suite.ended for suite in self.suites)
        failed = sum(suite.failed for suite in self.suites)
        with self.lock:
            rooms = ", ".join(self.running)
        print(
            f"reve: {seconds // 60}:{seconds % 60:02} {ended} tests done, {failed} failed"
            + (f"; running {rooms}" if rooms else ""),
            file=sys.stderr,
        )


def read_output(suite, output):
    """Copies the output of a suite to its log and counts its finished tests."""
    with suite.log.open("a", buffering=1) as log:
        for line in output:
            log.write(line)
            ended = ENDED.search(line)
            # ctest repeats the lines of a test that failed.
            if ended and (ended.lastgroup != "googletest" or suite.name == "law-contract"):
                suite.ended += 1
                if ended[ended.lastgroup] not in GOOD:
                    suite.failed += 1
                    print(f"reve: FAILED {suite.name}: {line.strip()}", file=sys.stderr)


def holders(pipe):
    """Returns the numbers and commands of the other processes that can write to a pipe."""
    wanted = os.readlink(f"/proc/self/fd/{pipe.fileno()}")
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if int(process.name) != os.getpid() and any(
                os.readlink(file) == wanted for file in (process / "fd").iterdir()
            ):
                command = (process / "cmdline").read_bytes().replace(b"\0", b" ")
                found.append(f"process {process.name}: {command.decode(errors='replace')}")
        except OSError:
            pass  # it has ended, or belongs to another account
    return found


def report_end(suite, end):
    """Writes a report with one failed test, named after the suite, if the suite ended badly although
    no test in its own report failed, or if it has no complete report."""
    failed = [case for case in test_summary.cases(suite.report) if case.outcome == "failed"]
    if any(case.part for case in failed):
        return
    if failed:
        suite.report.rename(suite.report.with_suffix(".cut"))  # so that it does not count as well
        end = f"{end or 'ended'} with a report that is cut"
    elif not suite.report.exists():
        end = f"{end or 'ended'} without a report"
    elif end:
        end += ", although no test in its report failed"
    else:
        return
    lines = suite.log.read_text(errors="replace").splitlines() if suite.log.exists() else []
    text = "\n".join([f"The suite {suite.name} {end}.", *lines[-LAST_LINES:]])
    print(f"reve: FAILED {suite.name}: {end}", file=sys.stderr)
    root = ET.Element("testsuite", name=suite.name)
    failed = ET.SubElement(root, "testcase", name=suite.name, part="")
    # XML cannot contain all characters that a program may write.
    ET.SubElement(failed, "failure").text = re.sub(r"[^\t\n\x20-\ud7ff\ue000-\ufffd]", "?", text)
    ET.ElementTree(root).write(suite.log.with_suffix(".end.xml"), encoding="utf-8")


def write_times(suites, file):
    """Writes a table of the suites, the one with the most processor time first."""
    costly = sorted(suites, key=lambda suite: -suite.processor_seconds)
    with file.open("w") as table:
        print("suite, wall time [s], processor time [s]", file=table)
        for suite in costly:
            print(f"{suite.name}, {suite.seconds:.1f}, {suite.processor_seconds:.1f}", file=table)


def failed_parts(reports):
    """Returns, by room, the tests that failed in the last run; a room or project without a report
    runs completely."""
    failed = {}
    for room in ROOMS:
        for project in PROJECTS.get(room, [""]):
            place = reports / room / project
            if place.exists():
                cases = list(test_summary.cases(place))
                parts = sorted({case.part for case in cases if case.outcome == "failed"})
                if parts or not cases:
                    if "" in parts:  # a suite ended badly
                        parts = []
                    named = [f"{project}/{part}" for part in parts] or [project]
                    failed.setdefault(room, []).extend(named if project else parts)
    return failed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--failed", action="store_true")
    parser.add_argument("rooms", nargs="*")
    given = parser.parse_intermixed_args()
    parts = {}
    for room, _, part in (name.partition("/") for name in given.rooms or ROOMS):
        parts.setdefault(room, []).extend([part] if part else [])
    reports = given.root / "build/reports/tests"
    if given.failed:
        failed = failed_parts(reports)
        parts = {room: failed[room] for room in parts if room in failed}
        if not parts:
            print("reve: no test failed in the last run, or there was none", file=sys.stderr)
    rooms = [room for room in ROOMS if room in parts]
    shutil.rmtree(reports, ignore_errors=True)
    plan = Plan(given.root, given.quick)
    places = [place for room in rooms for place in plan.places(room, parts[room])]
    for place, _ in places:
        (reports / place).mkdir(parents=True)
    # Long suites come first, so that all threads end at about the same time.
    ordered = sorted(places, key=lambda one: (one[0] not in LONG, one[0] in BATCHED))
    suites = [suite for place, narrow in ordered for suite in plan.suites(place, narrow)]
    suites.sort(key=lambda suite: not suite.name.endswith("-waiting"))
    Runner(suites).run()
    write_times(suites, reports / "times.csv")
    reported = [place for place, _ in places]
    if os.environ.get("REVE_TESTS_NOT_BUILT"):
        # Tests of an earlier build may have run instead. A place without reports counts as a
        # failure.
        (reports / BUILD).mkdir()
        reported.insert(0, BUILD)
    return test_summary.report(reports, reported)


if __name__ == "__main__":
    sys.exit(main())
