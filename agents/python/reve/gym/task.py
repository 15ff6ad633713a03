# SPDX-License-Identifier: Apache-2.0
"""What an agent is to learn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Iterable, Optional, Tuple

import gymnasium
import numpy

from ..protocol import Act, Argument, Perception

Edit = Tuple[str, str, Argument]
"""An item, one of its properties such as `physics.velocity`, and the value it gets, in the
property's own unit.
"""


class Task(ABC):
    """What one agent observes, does and is rewarded for. It keeps no state of its own: all it goes
    by is what is perceived.
    """

    observation_space: gymnasium.Space[Any]
    action_space: gymnasium.Space[Any]
    body: Optional[str] = None
    """The item that the agent gets as its body; None for one that the world chooses."""

    def begin(self, random: numpy.random.Generator) -> Iterable[Edit]:
        """How this episode's start is different from the world's."""
        return ()

    @abstractmethod
    def observe(self, perception: Perception) -> Any:
        """An element of `observation_space`."""

    @abstractmethod
    def act(self, action: Any) -> Iterable[Act]:
        """What the body does for an element of `action_space`."""

    @abstractmethod
    def reward(self, perception: Perception) -> float:
        """For having come to what is perceived."""

    def is_over(self, perception: Perception) -> bool:
        """Whether the episode ends there."""
        return False
