# SPDX-License-Identifier: Apache-2.0
"""Explores a world: goes to the most interesting item, pushes it until it moves, then takes the
next.

An item is interesting if its symbol `interest` is high. Among items of equal `interest`, an item is
more interesting if it differs from the others. A value of a symbol counts more if fewer items share
it. An item that was pushed counts as boring for a while. If the agent's body has an action `roll`,
the agent moves to the item and runs against it. If the item has an action `push`, the agent
performs this action. The last line on standard output is a JSON summary.

    ./reve serve worlds/playground --port 7777 &
    python3 curious.py --port 7777 --seconds 30
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from typing import Any, Dict, List, Optional, Sequence, Tuple

import reve

Vector = Tuple[float, float, float]

_EVERYBODY_HAS = ("name", "class", "dimensions", "interest")
_MOVED_ENOUGH = 0.5  # m, after which a pushed item counts as moved
_PATIENCE = 8.0  # s, spent on one item at most
_BORED_FOR = 12.0  # s, for which a pushed item is ignored


def surprise(item: reve.Item, items: Sequence[reve.Item]) -> float:
    """Returns how much an item differs from the others [bits].

    A symbol value that one item in eight shares counts three bits.
    """
    bits = 0.0
    for symbol, value in item.symbols.items():
        if symbol not in _EVERYBODY_HAS:
            alike = sum(1 for other in items if other.symbols.get(symbol) == value)
            bits -= math.log2(alike / len(items))
    return bits


def interest(item: reve.Item, items: Sequence[reve.Item]) -> Tuple[float, float, str]:
    """Returns the sort key of an item. Equally interesting items are sorted by name, so that runs
    are reproducible."""
    declared = item.symbols.get("interest", 0.0)
    number = float(declared) if isinstance(declared, (int, float)) else 0.0
    return number, surprise(item, items), item.name


def along(start: Vector, end: Vector, length: float) -> List[float]:
    """Returns a vector of the given length in the direction from start to end. If both are equal,
    the vector is along x."""
    distance = math.dist(start, end)
    if distance == 0.0:
        return [length, 0.0, 0.0]
    return [length * (b - a) / distance for a, b in zip(start, end)]


class Curious:
    """An agent that explores one world for a while and records what it perceived and did."""

    def __init__(self, agent: reve.Agent, options: argparse.Namespace) -> None:
        self.agent = agent
        self.options = options
        self.perceptions = 0
        self.frames: List[int] = []
        self.favourite: Optional[str] = None
        self.chosen_at = 0.0
        self.found_at: Optional[Vector] = None
        self.last_seen: Optional[Vector] = None
        self.bored_until: Dict[str, float] = {}
        self.path = 0.0
        self.next_push = 0.0
        self.pushes = 0
        self.moved: List[str] = []
        self.refusals: Counter[str] = Counter()
        self.events: Counter[str] = Counter()

    def explore(self) -> None:
        begun: Optional[float] = None
        for perception in self.agent.perceptions(every=self.options.every):
            begun = perception.time if begun is None else begun
            self.perceptions += 1
            self.frames = [self.frames[0] if self.frames else perception.frame, perception.frame]
            self.look(perception)
            self.events.update(event.type for event in self.agent.events())
            if self.is_done(perception, begun):
                return

    def is_done(self, perception: reve.Perception, begun: float) -> bool:
        frames = self.options.frames
        if frames is not None and perception.frame - self.frames[0] >= frames:
            return True
        return bool(perception.time - begun >= self.options.seconds)

    def look(self, perception: reve.Perception) -> None:
        me = perception.find(self.agent.body or "")
        item = self.most_interesting(perception)
        if item is None or item.location is None:
            return
        if item.name != self.favourite:
            self.choose(item, perception.time)
        if self.last_seen is not None:
            self.path += math.dist(item.location, self.last_seen)
        self.last_seen = item.location
        if math.dist(item.location, self.found_at or item.location) > _MOVED_ENOUGH:
            self.moved.append(item.name)
            self.lose_interest(item, perception.time)
        elif perception.time - self.chosen_at > _PATIENCE:
            self.lose_interest(item, perception.time)
        position = me.location if me is not None and me.location is not None else (0.0, 0.0, 0.0)
        if me is not None and "force" in me.actions.get("roll", {}):
            self.do(me, "roll", force=along(position, item.location, self.options.force))
        if "impulse" in item.actions.get("push", {}) and perception.time >= self.next_push:
            self.next_push = perception.time + self.options.push_every
            if self.do(item, "push", impulse=along(position, item.location, self.options.strength)):
                self.pushes += 1

    def most_interesting(self, perception: reve.Perception) -> Optional[reve.Item]:
        """Returns the most interesting item that has a location, except the agent, grounds and
        boring items."""
        items = perception.items
        others = [
            i
            for i in items
            if i.location is not None
            and i.name != self.agent.body
            and i.symbols.get("class") != "ground"
            and self.bored_until.get(i.name, 0.0) <= perception.time
        ]
        return max(others, key=lambda item: interest(item, items), default=None)

    def choose(self, item: reve.Item, time: float) -> None:
        self.favourite, self.chosen_at = item.name, time
        self.found_at, self.last_seen = item.location, None
        self.next_push = time

    def lose_interest(self, item: reve.Item, time: float) -> None:
        self.bored_until[item.name] = time + _BORED_FOR
        self.favourite = None

    def do(self, item: reve.Item, action: str, **arguments: List[float]) -> reve.Result:
        result = self.agent.act(item, action, **arguments)
        if result.code is not None:
            self.refusals[result.code] += 1
        return result

    def summary(self, ended: str) -> Dict[str, Any]:
        self.events.update(event.type for event in self.agent.events())
        return {
            "agent": self.agent.name,
            "world": self.agent.welcome.world,
            "perceptions": self.perceptions,
            "firstFrame": self.frames[0] if self.frames else None,
            "lastFrame": self.frames[1] if self.frames else None,
            "favourite": self.favourite,
            "sawItMoveMetres": round(self.path, 3),
            "moved": self.moved,
            "pushes": self.pushes,
            "actsRefused": dict(sorted(self.refusals.items())),
            "events": dict(sorted(self.events.items())),
            "ended": ended,
        }


def parse(arguments: List[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Goes to the most interesting items of a world and pushes them."
    )
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=7777)
    parser.add_argument("--name", default="curious")
    parser.add_argument("--seconds", type=float, default=5.0, help="duration in world time [s]")
    parser.add_argument("--frames", type=int, help="maximum number of frames")
    parser.add_argument("--every", type=int, default=6, help="frames per perception")
    parser.add_argument(
        "--push-every", type=float, default=1.0, help="world time between pushes [s]"
    )
    parser.add_argument("--strength", type=float, default=0.5, help="impulse of a push [N*s]")
    parser.add_argument("--force", type=float, default=80.0, help="force to roll with [N]")
    return parser.parse_args(arguments)


def main(arguments: List[str]) -> int:
    options = parse(arguments)
    try:
        agent = reve.connect(options.host, options.port, name=options.name)
    except (OSError, reve.ReveError) as error:
        print(f"curious: cannot join {options.host}:{options.port}: {error}", file=sys.stderr)
        return 1
    with agent:
        curious = Curious(agent, options)
        ended = "done"
        try:
            curious.explore()
        except reve.Disconnected as error:
            ended = error.code
        except reve.ReveError as error:
            print(f"curious: {error}", file=sys.stderr)
            ended = error.code
    print(json.dumps(curious.summary(ended)))
    return 0 if ended in ("done", "closing") else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
