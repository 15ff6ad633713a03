#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the time of a frame without physics, the two bulk copies and DERIVE.

Runs a world of bodies under newton_motion and gravity_field at full speed. Prints the parts of the
busy time per body, as medians over the runs. The share is a ratio within one run, so it does not
depend on the speed of the machine. Exits with 1 if the share is above the target.
"""

import json
import random
import statistics
import tempfile
from pathlib import Path

import harness

PAID_FOR = ("PHYSICS advance", "PHYSICS rollback copy", "PUBLISH snapshot copy", "DERIVE")
LIMIT = 0.10


def write_world(path, bodies):
    """Writes a cloud of moving spheres in uniform gravity; equal numbers of bodies give equal
    worlds."""
    place = random.Random(bodies)
    lines = [
        "reve: 1",
        "name: cloud",
        "frame: {rate: 60, steps: 4}",
        "laws: [gravity_field, newton_motion]",
        "constants: {gravity: [0, -9.81, 0]}",
        "items:",
    ]
    for i in range(bodies):
        x, y, z = (round(place.uniform(-50, 50), 3) for _ in range(3))
        v = round(place.uniform(-1, 1), 3)
        lines.append(
            f"  - {{name: b{i}, physical: {{shape: sphere, radius: 0.1, "
            f"location: [{x}, {y}, {z}]}}, physics: {{mass: 1, velocity: [{v}, 0, 0]}}}}"
        )
    path.write_text("\n".join(lines) + "\n")


def run(world, seconds):
    return json.loads(
        harness.output([harness.ROOT / "reve", "run", world, "--seconds", seconds, "--json"])
    )


def main():
    options = harness.arguments(__doc__, "one run of 5 s with 1,000 bodies, which has no aim")
    options.add_argument("--bodies", type=int, help="how many (10000)")
    options.add_argument("--seconds", type=float, help="world time of each run [s] (60)")
    options.add_argument("--runs", type=int, help="how many (5)")
    options = options.parse_args()
    bodies, seconds, runs = (1_000, 5, 1) if options.quick else (10_000, 60, 5)
    options.bodies = options.bodies or bodies
    options.seconds = options.seconds or seconds
    options.runs = options.runs or runs

    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder) / "cloud.yaml"
        write_world(world, options.bodies)
        reports = [run(world, options.seconds) for _ in range(options.runs)]

    per_body = {}
    shares = []
    for report in reports:
        profile = report["profile"]
        for part, nanoseconds in profile["nanoseconds"].items():
            per_body.setdefault(part, []).append(nanoseconds / report["frames"] / options.bodies)
        paid_for = sum(profile["nanoseconds"][part] for part in PAID_FOR)
        shares.append(1 - paid_for / profile["busyNanoseconds"])

    print(f"{options.bodies} bodies, {options.runs} runs of {reports[0]['frames']} frames")
    for part, values in per_body.items():
        print(f"{part:24} {statistics.median(values):8.2f} ns/body and frame")
    share = statistics.median(shares)
    print(
        f"outside {', '.join(PAID_FOR)}: {share:.1%} of busy time"
        f" ({min(shares):.1%} to {max(shares):.1%}); aim: below {LIMIT:.0%}"
    )
    return 0 if options.quick or share < LIMIT else 1


if __name__ == "__main__":
    raise SystemExit(main())
