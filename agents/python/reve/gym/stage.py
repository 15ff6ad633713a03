# SPDX-License-Identifier: Apache-2.0
"""A world, and the agents that learn in it."""

from __future__ import annotations

from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

import gymnasium
import numpy
import numpy.typing

from ..client import Agent, Control, connect, control
from ..errors import ReveError
from ..protocol import Act, LockStep, Perception
from .task import Task

Address = Tuple[str, int]

Camera = Tuple[str, str]
"""A camera: the item that carries it, and the sensor's name.

The item is the body of one of the tasks, or an item that the world grants to agents as a body.
"""

RENDER_MODES: List[str] = ["rgb_array"]

_DEADLINE = 3600.0  # s; the server may allow less


def info(perception: Perception) -> Dict[str, Any]:
    """Returns all perceived data except the number of the frame, which differs between episodes."""
    return {"time": perception.time, "items": perception.items}


class Stage:
    """A world with the agents of the tasks. It makes no frames between two calls. Not
    thread-safe."""

    def __init__(
        self,
        address: Address,
        tasks: Mapping[str, Task],
        frames: int,
        render_mode: Optional[str] = None,
        camera: Optional[Camera] = None,
        world: Optional[str] = None,
    ) -> None:
        if frames < 1:
            raise ValueError(f"frames is {frames}; expected 1 or more")
        if render_mode is not None and (render_mode not in RENDER_MODES or camera is None):
            raise ValueError(
                f"render_mode is {render_mode!r} and camera {camera}; "
                f"expected {RENDER_MODES} and an item with a camera"
            )
        self._tasks = tasks
        self._frames = frames
        self._frame = 0
        self._world = world
        self._control = self._take(address)
        self._agents: Dict[str, Agent] = {}
        self._guest: Optional[Agent] = None
        try:
            for name, task in tasks.items():
                self._agents[name] = connect(
                    *address,
                    name=name,
                    body=task.body,
                    world=world,
                    time=LockStep(frames, _DEADLINE),
                )
            self._camera = camera if render_mode is not None else None
            self._viewer = None if self._camera is None else self._view(address, self._camera[0])
        except BaseException:
            self.close()
            raise

    def _take(self, address: Address) -> Control:
        try:
            name = "-".join(("stage", *self._tasks))[:64]
            return control(*address, name=name, world=self._world)
        except ReveError as error:
            if error.code != "name-taken":
                raise
            raise ReveError(
                error.code,
                f"the world has an environment of {', '.join(self._tasks)} already",
                "close that, or serve a world for each",
            ) from error

    def _view(self, address: Address, item: str) -> Agent:
        """Returns the agent whose body carries the camera. If no task has this body, another agent
        joins."""
        for agent in self._agents.values():
            if agent.body == item:
                return agent
        name = "-".join(("view", *self._tasks))[:64]
        self._guest = connect(*address, name=name, body=item, world=self._world)
        return self._guest

    @property
    def fps(self) -> float:
        """Number of steps per second of world time."""
        return self._control.welcome.rate / self._frames

    def render(self) -> Optional[numpy.typing.NDArray[numpy.uint8]]:
        """Returns the camera's current picture, (height x width x 3) in sRGB; None without a
        camera."""
        if self._viewer is None or self._camera is None:
            return None
        image = self._viewer.look(self._camera[1])
        if image.colour is None:
            raise ReveError(
                "no-picture", f"the camera {self._camera[1]} of {self._camera[0]} has no colour"
            )
        colour = numpy.frombuffer(image.colour, numpy.uint8)
        return colour.reshape(image.height, image.width, 3).copy()

    def reset(self, random: numpy.random.Generator) -> Dict[str, Perception]:
        """Restores the initial state of the world and applies the tasks' changes.

        Returns the perceptions after one step.
        """
        rewound = self._control.rewind()
        if rewound.frame is None:
            reason = rewound.reason or "the world cannot be restored"
            raise ReveError(rewound.code or "refused", reason)
        for agent in self._agents.values():
            agent.observe(rewound.frame)
        self._frame = rewound.frame
        edits = [edit for task in self._tasks.values() for edit in task.begin(random)]
        results = self._control.begin_edits(edits)
        perceptions = self.step({})
        for (item, property, _), result in zip(edits, results()):
            if not result:
                raise ReveError(result.code or "refused", f"{property} of {item}: {result.reason}")
        return perceptions

    def step(self, acts: Mapping[str, Iterable[Act]]) -> Dict[str, Perception]:
        """Performs the acts of all agents, advances by a step, and returns the perceptions."""
        if self._frame == 0:
            raise gymnasium.error.ResetNeeded("an episode begins with reset, and step comes after")
        for name, agent in self._agents.items():
            agent.ready(*acts.get(name, ()))
        self._frame += self._frames
        return {
            name: self._perceived(name, agent.observe(self._frame))
            for name, agent in self._agents.items()
        }

    def _perceived(self, name: str, perception: Perception) -> Perception:
        if perception.frame != self._frame:
            raise ReveError(
                "late",
                f"the world went on to frame {perception.frame} without agent {name}, "
                f"which was in frame {self._frame}",
                "serve it with a longer --deadline and --waiting off, or think faster",
            )
        for result in perception.results:
            if not result:
                raise ReveError(result.code or "refused", f"an act of {name}: {result.reason}")
        return perception

    def close(self) -> None:
        """Leaves the world. Another call has no effect."""
        for client in (*self._agents.values(), self._guest, self._control):
            if client is not None:
                client.close()
