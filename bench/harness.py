# SPDX-License-Identifier: Apache-2.0
"""Shared code of the benchmarks: arguments, requirements on the machine, and builds."""

import argparse
import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "build/bench"
LAWS = OUT / "vesper-laws/lib"
PEERS = OUT / "peers"


def arguments(description, quick):
    """Returns a parser with --help and --quick.

    `description` is the docstring of the program, `quick` describes the measurement of its short
    form.
    """
    summary, _, details = description.partition("\n")
    parser = argparse.ArgumentParser(
        prog=str(Path(sys.argv[0]).resolve().relative_to(ROOT)),
        description=summary,
        epilog=details.strip("\n"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"shows in at most half a minute, once all is built, whether the benchmark works: {quick}; "
        "writes no page",
    )
    return parser


def fail(message):
    sys.exit(f"bench: {message}")


def need(program, package):
    """Ends the benchmark with a message unless the program is on the PATH."""
    if shutil.which(program) is None:
        fail(f"{program} is missing; install it with: sudo apt-get install {package}")


def java_home():
    """Returns the folder of the JDK that ./reve uses."""
    script = '. "$1" && find_java javac && printf %s "$REVE_JAVA_HOME"'
    java_sh = ROOT / "scripts/release/java.sh"
    found = subprocess.run(
        ["bash", "-c", script, "bench", java_sh], stdout=subprocess.PIPE, text=True
    )
    if found.returncode != 0:
        sys.exit(found.returncode)  # java.sh has printed the reason
    return Path(found.stdout)


def shell(*command):
    """Runs a command whose output goes to stderr, and ends the benchmark if it fails."""
    command = [str(part) for part in command]
    try:
        code = subprocess.run(command, stdout=sys.stderr).returncode
    except FileNotFoundError:
        fail(f"{command[0]} is missing; ./reve build installs what building needs")
    if code != 0:
        fail(f"this command failed with exit code {code}; its output says why: {' '.join(command)}")


def output(command, **environment):
    """Returns the output of a program of a benchmark. Ends the benchmark if the program fails."""
    command = [str(part) for part in command]
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, env=os.environ | environment)
    if done.returncode != 0:
        fail(
            f"this program failed with exit code {done.returncode}; its message says why: "
            f"{' '.join(command)}"
        )
    return done.stdout


def install_peers():
    """Installs the programs of bench/peers/requirements.txt, which PEERS / "bin/python" imports."""
    if not PEERS.exists():
        venv.create(PEERS, with_pip=True)
    requirements = ROOT / "bench/peers/requirements.txt"
    shell(PEERS / "bin/pip", "install", "-q", "--disable-pip-version-check", "-r", requirements)


def cmake(folder, source, *options, targets=()):
    """Builds a CMake project of the checkout in build/bench/FOLDER as released."""
    shell(
        "cmake",
        "-S",
        ROOT / source,
        "-B",
        OUT / folder,
        "-G",
        "Ninja",
        "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
        *options,
    )
    shell("cmake", "--build", OUT / folder, *(f"--target={target}" for target in targets))


def build(name, laws=None):
    """Builds the engine, bench/NAME and laws: those listed, none if empty, all by default."""
    found = f"-DVesper_DIR={OUT}/vesper"
    cmake("vesper", "vesper-native", "-DBUILD_TESTING=OFF")
    if laws is None or laws:
        targets = [f"vesper_law_{law}" for law in laws or ()]
        cmake("vesper-laws", "laws", "-DBUILD_TESTING=OFF", found, targets=targets)
    cmake(name, f"bench/{name}", found)
