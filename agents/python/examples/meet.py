# SPDX-License-Identifier: Apache-2.0
"""Two agents meet in the dark: one calls, and the other one goes to where it hears the voice.

The caller says where it is in every frame. The seeker walks toward the voice that it heard last.
Words are lost on the way. More words are lost if the agents are farther apart. As soon as the
seeker touches the caller, it hears who speaks, and answers. Each agent prints what it hears, and a
JSON summary in the last line.

    ./reve serve agents/python/examples/meet.yaml --port 7777 &
    python3 meet.py caller --port 7777 &
    python3 meet.py seeker --port 7777
"""

from __future__ import annotations

import argparse
import json
import os
from typing import List, Sequence

import reve

_STRIDE = 0.4  # m per frame
_ROUNDS = 1000
_ANSWERS = 5  # times that the seeker says that it is there


def call(agent: reve.Agent) -> bool:
    """Calls until the agent hears an answer. Returns True if it has heard one."""
    agent.observe()
    for number in range(_ROUNDS):
        perception = agent.step(reve.Act.say(f"here I am, call number {number}"))
        show(perception.heard)
        if perception.heard:
            return True
    return False


def seek(agent: reve.Agent) -> bool:
    """Follows the voice until it has a name. Returns True if the agent has found the speaker."""
    perception = agent.observe()
    direction = (0.0, 0.0, 0.0)
    for _ in range(_ROUNDS):
        show(perception.heard)
        for heard in perception.heard:
            if heard.speaker is not None:
                for _ in range(_ANSWERS):
                    agent.step(reve.Act.say(f"I have found you, {heard.speaker}"))
                return True
            direction = heard.direction
        stride = [_STRIDE * component for component in direction]
        perception = agent.step(reve.Act(None, "walk", {"by": stride}))
    return False


def show(voices: Sequence[reve.Heard]) -> None:
    """Prints what was heard. Texts of other agents are printed as literals, so that they cannot
    contain commands for the terminal."""
    for heard in voices:
        words: List[str] = [f"{heard.distance:.2f} m", heard.speaker or "a voice"]
        print(heard.frame, *words, json.dumps(heard.text), heard.lost)


def main() -> None:
    parser = argparse.ArgumentParser(description="Meets another agent in the dark.")
    parser.add_argument("role", choices=["caller", "seeker"])
    parser.add_argument("--host", default=os.environ.get("REVE_HOST", "127.0.0.1"))
    parser.add_argument("--port", type=int, default=int(os.environ.get("REVE_PORT", "7777")))
    options = parser.parse_args()
    with reve.connect(
        options.host,
        options.port,
        name=options.role,
        token=os.environ.get("REVE_TOKEN"),
        time=reve.LockStep(deadline=60),
        timeout=60,
    ) as agent:
        met = call(agent) if options.role == "caller" else seek(agent)
        print(json.dumps({"agent": agent.name, "met": met}))


if __name__ == "__main__":
    main()
