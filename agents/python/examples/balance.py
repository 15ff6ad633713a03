# SPDX-License-Identifier: Apache-2.0
"""Learns to balance the pole of worlds/cart-pole in lock-step with the world, by trial and error.

The agent pushes the cart with a force that is a weighted sum of its observations. It finds good
weights by the cross-entropy method (R. Rubinstein, 1999): it tries random weights, keeps the best,
and tries new weights near these. The last line on standard output is a JSON summary.

    python3 balance.py --launcher ./reve
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from typing import Iterable, List, Tuple

import numpy
import reve
from gymnasium import spaces
from reve.gym import Edit, Environment, Task

Numbers = numpy.ndarray

STRONGEST = 10.0  # N, the largest force on the cart
FAR = 2.4  # m, distance from the middle at which an episode ends
FALLEN = 0.3  # rad, tilt at which an episode ends
AT_MOST = 600  # steps of an episode, 10 s


class Balance(Task):
    """Keep the pole upright and the cart near the middle: the reward is one point per frame."""

    observation_space = spaces.Box(-numpy.inf, numpy.inf, (4,), numpy.float64)
    action_space = spaces.Box(-1.0, 1.0, (1,), numpy.float32)
    body = "cart"

    def begin(self, random: numpy.random.Generator) -> Iterable[Edit]:
        lean = random.uniform(-0.1, 0.1)
        return [("tip", "physical.location", [math.sin(lean), math.cos(lean), 0.0])]

    def observe(self, perception: reve.Perception) -> Numbers:
        """Returns position [m] and speed [m/s] of the cart, and tilt [1] and its rate [1/s] of the
        pole."""
        cart, tip = perception["cart"], perception["tip"]
        place, tip_place = numpy.array(cart.location), numpy.array(tip.location)
        speed = numpy.array(cart.symbols["velocity"])
        tip_speed = numpy.array(tip.symbols["velocity"])
        return numpy.array([place[0], speed[0], tip_place[0] - place[0], tip_speed[0] - speed[0]])

    def act(self, action: Numbers) -> Iterable[reve.Act]:
        return [reve.Act("cart", "drive", {"force": STRONGEST * float(action[0])})]

    def reward(self, perception: reve.Perception) -> float:
        return 0.0 if self.is_over(perception) else 1.0

    def is_over(self, perception: reve.Perception) -> bool:
        where, _, lean, _ = self.observe(perception)
        return bool(abs(where) > FAR or abs(lean) > math.sin(FALLEN))


def play(environment: Environment, weights: Numbers, seed: int) -> float:
    """Runs one episode of the task and returns its points."""
    observation, _ = environment.reset(seed=seed)
    points, over, cut = 0.0, False, False
    while not (over or cut):
        action = numpy.clip([weights @ observation], -1.0, 1.0).astype(numpy.float32)
        observation, reward, over, cut, _ = environment.step(action)
        points += reward
    return points


def learn(environment: Environment, options: argparse.Namespace) -> Tuple[Numbers, List[float]]:
    """Returns the best weights, and the mean points of each generation of tried weights."""
    random = numpy.random.default_rng(options.seed)
    mean, spread = numpy.zeros(4), numpy.full(4, 3.0)
    history: List[float] = []
    for generation in range(options.generations):
        tries = mean + spread * random.standard_normal((options.tries, 4))
        points = numpy.array([play(environment, weights, seed=generation) for weights in tries])
        best = tries[numpy.argsort(-points, kind="stable")[: options.tries // 4]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.1
        history.append(float(points.mean()))
        told = f"mean {points.mean():.0f}, best {points.max():.0f} points"
        print(f"generation {generation + 1}: {told}", file=sys.stderr)
    return mean, history


def parse(arguments: List[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Learns to balance a pole.")
    parser.add_argument("--launcher", default="./reve", help="the project's launcher")
    parser.add_argument("--world", default="worlds/cart-pole")
    parser.add_argument("--generations", type=int, default=8)
    parser.add_argument("--tries", type=int, default=16, help="tries in each generation")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args(arguments)


def main(arguments: List[str]) -> int:
    options = parse(arguments)
    try:
        return run(options)
    except reve.ReveError as error:
        print(f"balance: {error}", file=sys.stderr)
        return 2


def run(options: argparse.Namespace) -> int:
    begun = time.monotonic()
    with reve.serve(options.world, launcher=options.launcher) as address:
        environment = Environment(address, Balance(), steps=AT_MOST)
        weights, history = learn(environment, options)
        final = [play(environment, weights, seed=1000 + i) for i in range(5)]
        environment.close()
    print(
        json.dumps(
            {
                "weights": [round(float(w), 3) for w in weights],
                "history": history,
                "final": final,
                "seconds": round(time.monotonic() - begun, 1),
            }
        )
    )
    return 0 if min(final) == AT_MOST else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
