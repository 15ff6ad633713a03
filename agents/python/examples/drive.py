# SPDX-License-Identifier: Apache-2.0
"""Drives a car through gates in a circle, by pure pursuit.

The agent perceives where the chassis and the posts of the gates are. It steers the front wheels so
that the car follows an arc to the middle of the next gate. The method is from R. C. Coulter,
Implementation of the pure pursuit path tracking algorithm, CMU-RI-TR-92-01, 1992. Both wheels of an
axle move on circles about the same centre, so the inner wheel is steered more and driven slower.
The last line on standard output is a JSON summary.

    ./reve serve worlds/car --port 7777 &
    python3 drive.py --port 7777
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from typing import Dict, List, Sequence, Tuple

import reve

Vector = Tuple[float, float, float]

_BASE = 0.7  # distance between the axles [m]
_TRACK = 0.62  # distance between the wheels of an axle [m]
_RADIUS = 0.15  # radius of the wheels [m]
_SPEED = 1.5  # speed of the car [m/s]
_STEER = 0.6  # largest angle of a front wheel [rad]
_TORQUE = {"steer": 30.0, "axle": 15.0}  # [N m]
_NEAR = 0.5  # distance from the middle of a gate at which the gate counts as passed [m]
_ROUNDS = 60 * 40  # frames after which the agent gives up


def rotated(v: Sequence[float], q: Sequence[float]) -> Vector:
    """Returns a vector that is rotated by a unit quaternion xyzw."""

    def cross(a: Sequence[float], b: Sequence[float]) -> Vector:
        return (
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        )

    t = [2.0 * x for x in cross(q[:3], v)]
    u = cross(q[:3], t)
    return (v[0] + q[3] * t[0] + u[0], v[1] + q[3] * t[1] + u[1], v[2] + q[3] * t[2] + u[2])


def gates(perception: reve.Perception) -> List[Vector]:
    """Returns the middles of the gates in their order."""
    posts: Dict[str, List[Vector]] = {}
    for item in perception.items:
        if item.name.startswith("gate ") and item.location is not None:
            posts.setdefault(item.name.split()[1], []).append(item.location)
    if not posts:
        raise SystemExit("drive: the world has no gates, expected worlds/car")
    middles = []
    for _, (a, b) in sorted(posts.items()):
        middles.append((0.5 * (a[0] + b[0]), 0.0, 0.5 * (a[2] + b[2])))
    return middles


def curvature(place: Vector, turn: Sequence[float], target: Vector) -> float:
    """Returns the curvature of the arc from the rear axle to a place [1/m], left is positive."""
    forward = rotated((1.0, 0.0, 0.0), turn)
    length = math.hypot(forward[0], forward[2])
    ahead = (forward[0] / length, forward[2] / length)
    rear = (place[0] - 0.5 * _BASE * ahead[0], place[2] - 0.5 * _BASE * ahead[1])
    way = (target[0] - rear[0], target[2] - rear[1])
    # The direction to the left of (x, z) is (z, -x), because the axes are right-handed with +Y up.
    left = way[0] * ahead[1] - way[1] * ahead[0]
    return 2.0 * left / max(way[0] ** 2 + way[1] ** 2, 0.01)


def acts(curve: float) -> List[reve.Act]:
    """Returns the acts that move the car along an arc."""
    most = math.tan(_STEER) / (_BASE + 0.5 * _TRACK * math.tan(_STEER))
    curve = max(-most, min(most, curve))
    result = []
    for side, sign in (("left", 1.0), ("right", -1.0)):
        share = 1.0 - sign * curve * 0.5 * _TRACK  # of the speed at this side
        angle = math.atan2(_BASE * curve, share)
        speed = _SPEED * share / _RADIUS
        steer = {"angle": angle, "torque": _TORQUE["steer"]}
        result.append(reve.Act(f"steer {side}", "move", steer))
        result.append(
            reve.Act(f"rear {side} axle", "drive", {"speed": speed, "torque": _TORQUE["axle"]})
        )
    return result


def main() -> int:
    parser = argparse.ArgumentParser(description="Drives a car through gates.")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=7777)
    given = parser.parse_args()
    passed: List[int] = []
    rounds = 0
    way = 0.0
    with reve.connect(
        given.host,
        given.port,
        name="drive",
        time=reve.LockStep(deadline=600),
        timeout=60,
    ) as agent:
        perception = agent.observe()
        goals = gates(perception)
        last = None
        while len(passed) < len(goals) and rounds < _ROUNDS:
            car = perception.find("chassis")
            if car is None or car.location is None or car.orientation is None:
                raise SystemExit("drive: the world has no item chassis, expected worlds/car")
            if last is not None:
                way += math.dist(last, car.location)
            last = car.location
            goal = goals[len(passed)]
            if math.hypot(goal[0] - last[0], goal[2] - last[2]) < _NEAR:
                passed.append(len(passed) + 1)
                print(f"gate {len(passed)} in frame {perception.frame}", file=sys.stderr)
                continue
            perception = agent.step(*acts(curvature(last, car.orientation, goal)))
            rounds += 1
    print(json.dumps({"gates": passed, "rounds": rounds, "metres": round(way, 2)}))
    return 0 if len(passed) == len(goals) else 1


if __name__ == "__main__":
    sys.exit(main())
