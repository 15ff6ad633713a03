# SPDX-License-Identifier: Apache-2.0
"""Walks a robot with four legs straight ahead, with diagonal pairs of legs in turn (a trot).

Each foot moves along a closed path below its hip: backwards on the ground, then forwards in the
air. The agent computes the angles of hip and knee from the place of the foot, by inverse kinematics
of the two links. The servos move the joints to these angles. The agent perceives the place and the
direction of the trunk. If the trunk leaves its line, the legs of one side make longer steps, which
steer it back. The last line on standard output is a JSON summary.

    ./reve serve worlds/walker --port 7777 &
    python3 walk.py --port 7777
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from typing import Dict, Sequence, Tuple

import reve

_LINK = 0.2  # length of thigh and of shank [m]
_STAND = -2.0 * math.atan2(0.12, 0.16)  # angles of hip and knee at their zero, from straight legs
_HEIGHT = 0.32  # height of the hips above the feet of the standing robot [m]
_STEP = 0.12  # length of a step [m]
_LIFT = 0.05  # height of a foot in the air [m]
_RATE = 2.0  # steps of each leg per second [1/s]
_GROUND = 0.55  # share of the time of a step in which the foot is on the ground
_TORQUE = 30.0  # largest torque of a servo [N m]
_FRAMES = 60  # frames per second of world time
_LEGS = {"front left": 0.0, "front right": 0.5, "hind left": 0.5, "hind right": 0.0}  # phases


def angles(x: float, y: float) -> Tuple[float, float]:
    """Returns the angles of hip and knee for a foot ahead (x) of and above (y) its hip [m]."""
    way = min(math.hypot(x, y), 1.999 * _LINK)
    knee = 2.0 * math.acos(0.5 * way / _LINK)
    hip = math.atan2(-x, -y) - 0.5 * knee
    return hip - 0.5 * _STAND, knee + _STAND


def foot(phase: float, step: float, lift: float) -> Tuple[float, float]:
    """Returns the place of a foot relative to its hip [m] at a phase of its step, from 0 to 1."""
    if phase < _GROUND:
        return step * (0.5 - phase / _GROUND), -_HEIGHT
    air = (phase - _GROUND) / (1.0 - _GROUND)
    ahead = air - math.sin(2.0 * math.pi * air) / (2.0 * math.pi)
    return step * (ahead - 0.5), lift * math.sin(math.pi * air) - _HEIGHT


def heading(q: Sequence[float], start: Sequence[float]) -> float:
    """Returns the angle about +Y from the orientation at the start to an orientation xyzw [rad].

    It is positive to the left.
    """
    x, y, z, w = (-start[0], -start[1], -start[2], start[3])  # the inverse of start
    up = q[3] * y - q[0] * z + q[1] * w + q[2] * x  # Y of the product of q and this inverse
    along = q[3] * w - q[0] * x - q[1] * y - q[2] * z
    return 2.0 * math.atan2(up, along) if along > 0 else 2.0 * math.atan2(-up, -along)


def targets(time: float, left: float, turned: float) -> Dict[str, float]:
    """Returns the angle of each joint in a frame [rad].

    time: time since the start [s]; left: distance of the trunk to the left of its line [m]; turned:
    heading to the left [rad].
    """
    start = min(1.0, time)  # the steps grow in the first second
    steer = max(-0.5, min(0.5, 2.0 * turned + 0.8 * left))
    result = {}
    for leg, phase in _LEGS.items():
        longer = 1.0 + steer if leg.endswith("left") else 1.0 - steer
        at = foot((_RATE * time + phase) % 1.0, start * longer * _STEP, start * _LIFT)
        result[f"{leg} hip"], result[f"{leg} knee"] = angles(*at)
    return result


def angle(perception: reve.Perception, joint: str) -> float:
    """Returns the angle of a joint that the agent perceives [rad]."""
    item = perception.find(joint)
    value = None if item is None else item.symbols.get("angle")
    if not isinstance(value, (int, float)):
        raise SystemExit(f"walk: no joint {joint} has the symbol angle, expected worlds/walker")
    return value


def trunk(perception: reve.Perception) -> Tuple[Sequence[float], Sequence[float]]:
    """Returns location and orientation of the trunk."""
    item = perception.find("trunk")
    if item is None or item.location is None:
        raise SystemExit("walk: the world has no item trunk, expected worlds/walker")
    return item.location, item.orientation


def main() -> int:
    parser = argparse.ArgumentParser(description="Walks a robot with four legs.")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=7777)
    parser.add_argument("--seconds", type=float, default=15.0)
    given = parser.parse_args()
    lowest = math.inf
    most = 0.0
    with reve.connect(
        given.host,
        given.port,
        name="walk",
        time=reve.LockStep(deadline=600),
        timeout=60,
    ) as agent:
        perception = agent.observe()
        start, ahead = trunk(perception)
        here = start
        rounds = round(given.seconds * _FRAMES)
        for frame in range(rounds):
            here, orientation = trunk(perception)
            lowest = min(lowest, here[1])
            # The robot starts in the direction +X, so its left side is in the direction -Z.
            turned = heading(orientation, ahead)
            wanted = targets(frame / _FRAMES, start[2] - here[2], turned)
            perception = agent.step(
                *(
                    reve.Act(joint, "move", {"angle": place, "torque": _TORQUE})
                    for joint, place in wanted.items()
                )
            )
            for joint, place in wanted.items():
                most = max(most, abs(angle(perception, joint) - place))
    summary = {
        "metres": round(here[0] - start[0], 2),
        "aside": round(here[2] - start[2], 2),
        "lowest": round(lowest, 3),
        "missed": round(most, 3),
        "rounds": rounds,
    }
    print(json.dumps(summary))
    return 0


if __name__ == "__main__":
    sys.exit(main())
