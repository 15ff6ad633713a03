"""A curious agent: looks for the item it finds most interesting, follows it with its eyes, and pushes it at times.

Interesting is what has a high symbol `interest`, or, among equals, what is unlike the rest: each symbol counts the
more the fewer items share its value. The last line on standard output is a JSON summary.

    python3 curious.py --port 7777 --seconds 10
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from typing import Any, Dict, List, Optional, Tuple

import reve

Location = Tuple[float, float, float]

_EVERYBODY_HAS = ("name", "class", "dimensions", "interest")


def surprise(item: reve.Item, items: Tuple[reve.Item, ...]) -> float:
    """How unlike the rest an item is [bits]: a symbol that one item in eight shares counts three."""
    bits = 0.0
    for symbol, value in item.symbols.items():
        if symbol not in _EVERYBODY_HAS:
            alike = sum(1 for other in items if other.symbols.get(symbol) == value)
            bits -= math.log2(alike / len(items))
    return bits


def interest(item: reve.Item, items: Tuple[reve.Item, ...]) -> Tuple[float, float, str]:
    """Sorts items; the name decides between equals, so that two runs agree."""
    declared = item.symbols.get("interest", 0.0)
    number = float(declared) if isinstance(declared, (int, float)) else 0.0
    return number, surprise(item, items), item.name


def most_interesting(perception: reve.Perception, own_body: str) -> Optional[reve.Item]:
    """Of what has a place and is not the agent itself."""
    items = perception.items
    others = [i for i in items if i.location is not None and i.name != own_body]
    return max(others, key=lambda item: interest(item, items), default=None)


class Curious:
    """Watches one world for a while and remembers what it saw and did."""

    def __init__(self, agent: reve.Agent, options: argparse.Namespace) -> None:
        self.agent = agent
        self.options = options
        self.perceptions = 0
        self.frames: List[int] = []
        self.favourite: Optional[str] = None
        self.last_seen: Optional[Location] = None
        self.path = 0.0
        self.next_push: Optional[float] = None
        self.pushes = 0
        self.refusals: Counter[str] = Counter()
        self.events: Counter[str] = Counter()

    def watch(self) -> None:
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
        return perception.time - begun >= self.options.seconds

    def look(self, perception: reve.Perception) -> None:
        item = most_interesting(perception, self.agent.body)
        if item is None or item.location is None:
            return
        if item.name != self.favourite:
            self.favourite, self.last_seen, self.next_push = item.name, None, None
        if self.last_seen is not None:
            self.path += math.dist(item.location, self.last_seen)
        self.last_seen = item.location
        self.push_at_times(item, perception)

    def push_at_times(self, item: reve.Item, perception: reve.Perception) -> None:
        if "impulse" not in item.actions.get("push", {}):
            return
        if self.next_push is None:
            self.next_push = perception.time + self.options.push_every
        if perception.time < self.next_push:
            return
        self.next_push = perception.time + self.options.push_every
        result = self.agent.act(item, "push", impulse=self.away_from_me(item, perception))
        if result:
            self.pushes += 1
        elif result.code is not None:
            self.refusals[result.code] += 1

    def away_from_me(self, item: reve.Item, perception: reve.Perception) -> List[float]:
        """An impulse of the chosen strength [N*s], along the line from the agent's body to the item."""
        me = perception.find(self.agent.body)
        here = me.location if me is not None and me.location is not None else (0.0, 0.0, 0.0)
        there = item.location if item.location is not None else here
        distance = math.dist(here, there)
        if distance == 0.0:
            return [self.options.strength, 0.0, 0.0]
        return [self.options.strength * (b - a) / distance for a, b in zip(here, there)]

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
            "pushes": self.pushes,
            "actsRefused": dict(sorted(self.refusals.items())),
            "events": dict(sorted(self.events.items())),
            "ended": ended,
        }


def parse(arguments: List[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Follows and pushes the most interesting item of a world.")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=7777)
    parser.add_argument("--name", default="curious")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to stay, in the world's time")
    parser.add_argument("--frames", type=int, help="leave after so many frames, if that is sooner")
    parser.add_argument("--every", type=int, default=6, help="perceive every that many frames")
    parser.add_argument("--push-every", type=float, default=1.0, help="seconds of the world between pushes")
    parser.add_argument("--strength", type=float, default=0.5, help="of a push [N*s]")
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
            curious.watch()
        except reve.Disconnected as error:
            ended = error.code
        except reve.ReveError as error:
            print(f"curious: {error}", file=sys.stderr)
            ended = error.code
    print(json.dumps(curious.summary(ended)))
    return 0 if ended in ("done", "closing") else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
