#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the time [s] from `./reve serve WORLD` to "ready", as a median over new processes.

WORLD is a world file of a few lines that makes ITEMS moving balls by `repeat:`. Prints the time
with one ball, which is the time to start a server, and the time with all balls.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import harness

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
    serve = [harness.ROOT / "reve", "serve", world, "--port", "0", "--json", "--seconds", "0.02"]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, text=True) as server:
        for line in server.stdout:
            if json.loads(line)["event"] == "ready":
                ready = time.monotonic() - start
        if server.wait() != 0:
            harness.fail(f"the server of {world} ended with exit code {server.returncode}")
    return ready


def main() -> None:
    options = harness.arguments(__doc__, "5,000 items, one run")
    options.add_argument("items", nargs="?", type=int, help="number of balls (100000)")
    options.add_argument("runs", nargs="?", type=int, help="how many of each (5)")
    chosen = options.parse_args()
    items = chosen.items or (5_000 if chosen.quick else 100_000)
    runs = chosen.runs or (1 if chosen.quick else 5)
    harness.shell(harness.ROOT / "reve", "build")
    with tempfile.TemporaryDirectory() as folder:
        medians = []
        for count in (1, items):
            world = Path(folder) / f"{count}.yaml"
            world.write_text(WORLD.format(items=count))
            medians.append(statistics.median(seconds_to_ready(world) for _ in range(runs)))
    print(f"{medians[0]:.2f} {medians[1]:.2f}")


if __name__ == "__main__":
    main()
