# SPDX-License-Identifier: Apache-2.0
"""The environment of one agent, for Gymnasium."""

from __future__ import annotations

from typing import Any, Dict, Optional, Tuple

import gymnasium

from ..protocol import Perception
from .stage import RENDER_MODES, Address, Camera, Stage, info
from .task import Task


class Environment(gymnasium.Env[Any, Any]):
    """An agent's task in a world that waits for the agent. While the environment is open, no other
    client may act in this world.

    `address` is host and port of a server, such as that of `reve.serve(...)`. `world` names one of
    the server's worlds, if it has several. A step has `frames` frames, and an episode at most
    `steps` steps. Every episode starts from the initial state of the world, with the changes of the
    task's `begin`. Therefore the same seed and actions give observations with the same bits. `info`
    contains the world's `time` [s] and the `items` that the agent perceives. With `render_mode`
    "rgb_array", `render` returns the picture of `camera`, which is a pair: the item that carries
    the camera, and the sensor's name. The item is the agent's body, or an item that the world
    grants to agents as a body.
    """

    metadata: Dict[str, Any] = {"render_modes": RENDER_MODES}

    def __init__(
        self,
        address: Address,
        task: Task,
        *,
        frames: int = 1,
        steps: Optional[int] = None,
        name: str = "learner",
        render_mode: Optional[str] = None,
        camera: Optional[Camera] = None,
        world: Optional[str] = None,
    ) -> None:
        self.task = task
        self.observation_space = task.observation_space
        self.action_space = task.action_space
        self._name = name
        self._steps = steps
        self._done = 0
        self.render_mode = render_mode
        self._stage = Stage(address, {name: task}, frames, render_mode, camera, world)
        self.metadata = {"render_modes": RENDER_MODES, "render_fps": self._stage.fps}

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[Any, Dict[str, Any]]:
        super().reset(seed=seed)
        self._done = 0
        perception = self._stage.reset(self.np_random)[self._name]
        return self.task.observe(perception), info(perception)

    def step(self, action: Any) -> Tuple[Any, float, bool, bool, Dict[str, Any]]:
        perception: Perception = self._stage.step({self._name: self.task.act(action)})[self._name]
        self._done += 1
        return (
            self.task.observe(perception),
            self.task.reward(perception),
            self.task.is_over(perception),
            self._steps is not None and self._done >= self._steps,
            info(perception),
        )

    def render(self) -> Any:
        return self._stage.render()

    def close(self) -> None:
        self._stage.close()
