# SPDX-License-Identifier: Apache-2.0
"""What benchmarks beside Jolt share: building both sides, and samples taken in turn."""

import json
import statistics
import subprocess
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "build/bench"
JOLT = OUT / "jolt"


def shell(*command):
    subprocess.run([str(part) for part in command], check=True)


def build(name, laws):
    """Builds the engine, laws and bench/NAME as they ship; returns the program and the laws'
    folder."""

    def cmake(folder, source, *options, targets=()):
        shell(
            "cmake",
            "-S",
            ROOT / source,
            "-B",
            OUT / folder,
            "-G",
            "Ninja",
            "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
            "-DBUILD_TESTING=OFF",
            *options,
        )
        shell("cmake", "--build", OUT / folder, *(f"--target={t}" for t in targets))

    cmake("vesper", "vesper-native")
    found = f"-DVesper_DIR={OUT}/vesper"
    cmake("vesper-laws", "laws", found, targets=[f"vesper_law_{law}" for law in laws])
    cmake(name, f"bench/{name}", found)
    return [OUT / name / f"{name}_bench", OUT / "vesper-laws/lib"]


def build_jolt(program):
    """Fetches jolt-jni and compiles bench/peers/jolt/PROGRAM.java; returns its command."""
    shell(
        "mvn",
        "-q",
        "dependency:copy-dependencies",
        f"-DoutputDirectory={JOLT}/jars",
        "-f",
        ROOT / "bench/peers/jolt/pom.xml",
    )
    (jar,) = (j for j in (JOLT / "jars").glob("jolt-jni-*.jar") if "Release" not in j.name)
    (native,) = (JOLT / "jars").glob("jolt-jni-*-ReleaseSp.jar")
    with zipfile.ZipFile(native) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".so"))
        library = archive.extract(name, JOLT)
    shell("javac", "-cp", jar, "-d", JOLT / "classes", ROOT / f"bench/peers/jolt/{program}.java")
    return [
        "java",
        "--enable-native-access=ALL-UNNAMED",
        "-cp",
        f"{jar}:{JOLT}/classes",
        program,
        library,
    ]


def sample(commands, rounds):
    """Runs the commands (by name) in turn; what each printed, as dictionaries."""
    samples = {name: [] for name in commands}
    for _ in range(rounds):
        for name, command in commands.items():
            out = subprocess.run(
                [str(part) for part in command],
                check=True,
                text=True,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            ).stdout
            samples[name].append(json.loads(out))
    return samples


def quartiles(values):
    if len(values) == 1:
        return values * 3
    return statistics.quantiles(values, n=4, method="inclusive")


def table_rows(samples, digits=0, largest=None):
    """Median and quartiles of the frames per second of processor time of each; the first is the
    peer that the others are compared with. `largest`: a share whose largest of all rounds is shown
    too."""
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
