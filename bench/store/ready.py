#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Seconds from `./reve serve WORLD` to "ready": a new process each time, median of some runs.

usage: bench/store/ready.py [ITEMS [RUNS]]

WORLD is a world file of a few lines that makes ITEMS moving balls by `repeat:`. Prints the time
with one ball, which is what starting a server costs, and with all of them.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WORLD = """\
reve: 1
name: many
laws: [newton_motion]
items:
  - name: ball-{{i}}
    repeat: {items}
    physical: {{shape: sphere, radius: 25 cm, location: "{{50 * box(1)}}"}}
    semantic: {{class: ball}}
    physics: {{mass: 1 kg, velocity: "{{ball(2)}}"}}
"""


def seconds_to_ready(world: Path) -> float:
    start = time.monotonic()
    serve = [ROOT / "reve", "serve", world, "--port", "0", "--json", "--seconds", "0.02"]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, text=True) as server:
        for line in server.stdout:
            if json.loads(line)["event"] == "ready":
                ready = time.monotonic() - start
        if server.wait() != 0:
            sys.exit(f"the server of {world} ended with exit code {server.returncode}")
    return ready


def main() -> None:
    items = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    subprocess.run([ROOT / "reve", "build"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        medians = []
        for count in (1, items):
            world = Path(folder) / f"{count}.yaml"
            world.write_text(WORLD.format(items=count))
            medians.append(statistics.median(seconds_to_ready(world) for _ in range(runs)))
    print(f"{medians[0]:.2f} {medians[1]:.2f}")


if __name__ == "__main__":
    main()
