# SPDX-License-Identifier: Apache-2.0
"""The task of a learning agent."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Iterable, Optional, Tuple

import gymnasium
import numpy

from ..protocol import Act, Argument, Perception

Edit = Tuple[str, str, Argument]
"""An item, one of its properties such as `physics.velocity`, and a value in the property's unit."""


class Task(ABC):
    """Observations, actions and rewards of one agent.

    A task has no state of its own; it depends only on perceptions.
    """

    observation_space: gymnasium.Space[Any]
    action_space: gymnasium.Space[Any]
    body: Optional[str] = None
    """The item that the agent gets as its body; None if the world chooses one."""

    def begin(self, random: numpy.random.Generator) -> Iterable[Edit]:
        """Returns the changes to the world at the start of this episode."""
        return ()

    @abstractmethod
    def observe(self, perception: Perception) -> Any:
        """Returns an element of `observation_space`."""

    @abstractmethod
    def act(self, action: Any) -> Iterable[Act]:
        """Returns the acts of the body for an element of `action_space`."""

    @abstractmethod
    def reward(self, perception: Perception) -> float:
        """Returns the reward for reaching this perception."""

    def is_over(self, perception: Perception) -> bool:
        """Returns True if the episode ends with this perception."""
        return False
