# SPDX-License-Identifier: Apache-2.0
"""Moves the hand of a robot arm to balls, one after the other, and pushes them off their posts.

The agent perceives where the hand, the joints and the balls are. From these locations it computes
the Jacobian, which states how fast each joint moves the hand. From the Jacobian it computes, by
damped least squares, the speeds of the joints that move the hand towards the ball. The method is
from C. W. Wampler, Manipulator inverse kinematic solutions based on vector formulations and damped
least-squares methods, IEEE Trans. Systems, Man and Cybernetics 16 (1986) 93. The last line on
standard output is a JSON summary.

    ./reve serve worlds/robot-arm --port 7777 &
    python3 reach.py --port 7777
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from typing import Dict, List, Sequence, Tuple

import reve

Vector = Tuple[float, float, float]

_UP = (0.0, 1.0, 0.0)
_SPEED = 0.6  # speed of the hand [m/s]
_DAMPING = 0.1  # limits the speeds of joints where the arm is stretched [m]
_MAX = {"waist": 2.0, "shoulder": 2.0, "elbow": 3.0}  # speeds of the joints [rad/s]
_TORQUE = {"waist": 80.0, "shoulder": 80.0, "elbow": 40.0}  # [N m]
_AWAY = 0.15  # a ball that is so far below its post has fallen [m]
_ROUNDS = 60 * 40  # frames after which the agent gives up


def minus(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(x * y for x, y in zip(a, b))


def rotated(v: Sequence[float], q: Sequence[float]) -> Vector:
    """Returns a vector rotated by a unit quaternion xyzw."""
    t = [2.0 * x for x in cross(q[:3], v)]
    u = cross(q[:3], t)
    return (v[0] + q[3] * t[0] + u[0], v[1] + q[3] * t[1] + u[1], v[2] + q[3] * t[2] + u[2])


def joint_speeds(columns: Sequence[Vector], velocity: Vector) -> List[float]:
    """Returns the speeds s = Jᵀ (J Jᵀ + d² 1)⁻¹ v of three joints [rad/s].

    columns: velocity of the hand for 1 rad/s of each joint [m]; velocity: that of the hand [m/s].
    """
    m = [
        [sum(c[i] * c[j] for c in columns) + (_DAMPING**2 if i == j else 0.0) for j in range(3)]
        for i in range(3)
    ]
    # By Cramer's rule, the inverse of a matrix with the rows a, b, c has the columns b×c, c×a and
    # a×b, divided by the determinant.
    inverse = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])]
    determinant = dot(m[0], inverse[0])
    w = [sum(inverse[j][i] * velocity[j] for j in range(3)) / determinant for i in range(3)]
    return [dot(column, w) for column in columns]


class Arm:
    """The places of the parts of the arm, from one perception."""

    def __init__(self, perception: reve.Perception) -> None:
        def place(name: str) -> Vector:
            item = perception.find(name)
            if item is None or item.location is None:
                raise SystemExit(f"reach: the world has no item {name}, expected worlds/robot-arm")
            return item.location

        turret = perception.find("turret")
        assert turret is not None and turret.orientation is not None
        self.hand = place("hand shape")
        forward = rotated((1.0, 0.0, 0.0), turret.orientation)
        across = cross(forward, _UP)  # the axis about which shoulder and elbow lift the arm
        self.columns = [
            cross(_UP, minus(self.hand, place("base"))),
            cross(across, minus(self.hand, place("upper arm look"))),
            cross(across, minus(self.hand, place("fore arm look"))),
        ]

    def towards(self, target: Sequence[float]) -> Dict[str, float]:
        """Returns the speeds of the joints that move the hand to a place."""
        way = minus(target, self.hand)
        distance = math.sqrt(dot(way, way))
        factor = _SPEED / max(distance, 0.05)
        speeds = joint_speeds(self.columns, (factor * way[0], factor * way[1], factor * way[2]))
        return {name: max(-_MAX[name], min(_MAX[name], speed)) for name, speed in zip(_MAX, speeds)}


def above(place: Sequence[float]) -> Vector:
    """Returns a place above and before a ball, from which the hand approaches it. Therefore the
    hand passes over the other balls."""
    return (0.75 * place[0], place[1] + 0.2, 0.75 * place[2])


def main() -> int:
    parser = argparse.ArgumentParser(description="Pushes balls off their posts with a robot arm.")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=7777)
    given = parser.parse_args()
    pushed: List[str] = []
    with reve.connect(
        given.host,
        given.port,
        name="reach",
        time=reve.LockStep(deadline=600),
        timeout=60,
    ) as agent:
        perception = agent.observe()
        goals = {
            item.name: item.location
            for item in perception.items
            if item.name.startswith("ball") and item.location is not None
        }
        approached: Dict[str, bool] = {}
        rounds = 0
        while len(pushed) < len(goals) and rounds < _ROUNDS:
            name = next(each for each in sorted(goals) if each not in pushed)
            start = goals[name]
            ball = perception.find(name)
            if ball is None or ball.location is None or ball.location[1] < start[1] - _AWAY:
                pushed.append(name)
                print(f"{name} fell in frame {perception.frame}", file=sys.stderr)
                continue
            arm = Arm(perception)
            over = above(start)
            if not approached.get(name) and math.dist(arm.hand, over) < 0.05:
                approached[name] = True
            target = ball.location if approached.get(name) else over
            speeds = arm.towards(target)
            perception = agent.step(
                *(
                    reve.Act(joint, "drive", {"speed": speed, "torque": _TORQUE[joint]})
                    for joint, speed in speeds.items()
                )
            )
            rounds += 1
    print(json.dumps({"pushed": pushed, "rounds": rounds}))
    return 0 if len(pushed) == len(goals) else 1


if __name__ == "__main__":
    sys.exit(main())
