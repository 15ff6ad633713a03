# SPDX-License-Identifier: Apache-2.0
"""What a frame costs besides physics, the two bulk copies and DERIVE.

    python3 bench/frame_overhead.py [--bodies 10000] [--seconds 60] [--runs 5]

Runs a world of bodies under newton_motion and gravity_field flat out, and prints where the busy
time went, per body, as the median over the runs. The share is a ratio within one run, so that the
speed of the machine cancels out.
"""

import argparse
import json
import random
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAID_FOR = ("PHYSICS advance", "PHYSICS rollback copy", "PUBLISH snapshot copy", "DERIVE")
LIMIT = 0.10


def write_world(path, bodies):
    """A cloud of moving spheres in uniform gravity; the same for the same number of bodies."""
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
    out = subprocess.run(
        [ROOT / "reve", "run", world, "--seconds", str(seconds), "--json"],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    ).stdout
    return json.loads(out)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--bodies", type=int, default=10_000)
    options.add_argument("--seconds", type=float, default=60, help="world time of each run [s]")
    options.add_argument("--runs", type=int, default=5)
    options = options.parse_args()

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
    return 0 if share < LIMIT else 1


if __name__ == "__main__":
    raise SystemExit(main())
