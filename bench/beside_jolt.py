# SPDX-License-Identifier: Apache-2.0
"""Shared code of the benchmarks with Jolt: builds both sides, and takes samples in turn."""

import json
import statistics
import subprocess
import zipfile

import harness

JOLT = harness.OUT / "jolt"


class Sides:
    """Both programs of a benchmark. Checks the requirements first, then builds the programs."""

    def __init__(self, name, laws, peer):
        harness.need("mvn", "maven")
        java = harness.java_home() / "bin"
        harness.build(name, laws)
        self.vesper = [harness.OUT / name / f"{name}_bench", harness.LAWS]
        self.jolt = build_jolt(java, peer)


def build_jolt(java, program):
    """Fetches jolt-jni and compiles bench/peers/jolt/PROGRAM.java; returns its command."""
    peers = harness.ROOT / "bench/peers/jolt"
    harness.shell(
        "mvn",
        "-q",
        "dependency:copy-dependencies",
        f"-DoutputDirectory={JOLT}/jars",
        "-f",
        peers / "pom.xml",
    )
    (jar,) = (j for j in (JOLT / "jars").glob("jolt-jni-*.jar") if "Release" not in j.name)
    (native,) = (JOLT / "jars").glob("jolt-jni-*-ReleaseSp.jar")
    with zipfile.ZipFile(native) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".so"))
        library = archive.extract(name, JOLT)
    harness.shell(java / "javac", "-cp", jar, "-d", JOLT / "classes", peers / f"{program}.java")
    return [
        java / "java",
        "--enable-native-access=ALL-UNNAMED",
        "-cp",
        f"{jar}:{JOLT}/classes",
        program,
        library,
    ]


def sample(commands, rounds):
    """Runs the commands (by name) in turn; returns what each printed, as dictionaries."""
    samples = {name: [] for name in commands}
    for _ in range(rounds):
        for name, command in commands.items():
            samples[name].append(run(command))
    return samples


def run(command):
    command = [str(part) for part in command]
    done = subprocess.run(command, text=True, capture_output=True)
    if done.returncode != 0:
        harness.fail(f"{' '.join(command)} failed with exit code {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


def quartiles(values):
    if len(values) == 1:
        return values * 3
    return statistics.quantiles(values, n=4, method="inclusive")


def table_rows(samples, digits=0, largest=None):
    """Returns rows with median and quartiles of the frames per second of processor time.

    The first sample is the baseline of the comparison. `largest` is the key of a fraction in each
    run; the maximum of this fraction over all rounds is also shown.
    """
    speeds = {
        name: [run["framesPerProcessorSecond"] for run in runs] for name, runs in samples.items()
    }
    peer = statistics.median(next(iter(speeds.values())))
    rows = ""
    for name, values in speeds.items():
        low, middle, high = quartiles(values)
        rows += (
            f"| {name} | {middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f}) | "
            f"{middle / peer:.2f} |"
        )
        if largest:
            shares = [run[largest] for run in samples[name] if largest in run]
            rows += f" {max(shares):.1%} |" if shares else " |"
        rows += "\n"
    return rows
