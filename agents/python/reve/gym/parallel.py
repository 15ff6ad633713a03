# SPDX-License-Identifier: Apache-2.0
"""The environment of several agents, for PettingZoo."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Optional, Tuple

import gymnasium
import numpy
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from .stage import RENDER_MODES, Address, Camera, Stage, info
from .task import Task


class ParallelEnvironment(ParallelEnv[str, Any, Any]):
    """Tasks of several agents, by agent name, in a world that waits for all of them.

    The arguments are those of `Environment`. An agent whose task is over stays in the world without
    acts until the episode has ended for all.
    """

    metadata: Dict[str, Any] = {"render_modes": RENDER_MODES, "name": "reve_v1"}

    def __init__(
        self,
        address: Address,
        tasks: Mapping[str, Task],
        *,
        frames: int = 1,
        steps: Optional[int] = None,
        render_mode: Optional[str] = None,
        camera: Optional[Camera] = None,
        world: Optional[str] = None,
    ) -> None:
        self.tasks = dict(tasks)
        self.possible_agents: List[str] = list(self.tasks)
        self.agents: List[str] = []
        self.render_mode = render_mode
        self._random = numpy.random.default_rng()
        self._steps = steps
        self._done = 0
        self._stage = Stage(address, self.tasks, frames, render_mode, camera, world)
        self.metadata = {**self.metadata, "render_fps": self._stage.fps}

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        return self.tasks[agent].observation_space

    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        return self.tasks[agent].action_space

    def reset(
        self, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[Dict[str, Any], Dict[str, Dict[str, Any]]]:
        if seed is not None:
            self._random, _ = seeding.np_random(seed)
        self.agents = list(self.possible_agents)
        self._done = 0
        perceptions = self._stage.reset(self._random)
        return (
            {a: self.tasks[a].observe(perceptions[a]) for a in self.agents},
            {a: info(perceptions[a]) for a in self.agents},
        )

    def step(
        self, actions: Dict[str, Any]
    ) -> Tuple[
        Dict[str, Any],
        Dict[str, float],
        Dict[str, bool],
        Dict[str, bool],
        Dict[str, Dict[str, Any]],
    ]:
        perceptions = self._stage.step(
            {a: self.tasks[a].act(action) for a, action in actions.items() if a in self.agents}
        )
        self._done += 1
        cut = self._steps is not None and self._done >= self._steps
        acted = self.agents
        over = {a: self.tasks[a].is_over(perceptions[a]) for a in acted}
        self.agents = [] if cut else [a for a in acted if not over[a]]
        return (
            {a: self.tasks[a].observe(perceptions[a]) for a in acted},
            {a: self.tasks[a].reward(perceptions[a]) for a in acted},
            over,
            dict.fromkeys(acted, cut),
            {a: info(perceptions[a]) for a in acted},
        )

    def render(self) -> Any:
        return self._stage.render()

    def close(self) -> None:
        self._stage.close()
