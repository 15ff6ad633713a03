"""A world, and the agents that learn in it."""

from __future__ import annotations

from typing import Any, Dict, Iterable, Mapping, Tuple

import numpy

from ..client import connect, control
from ..errors import ReveError
from ..protocol import Act, LockStep, Perception
from .task import Task

Address = Tuple[str, int]

_DEADLINE = 3600.0  # s; the server may allow less


def info(perception: Perception) -> Dict[str, Any]:
    """All that is perceived, but for the frame's number: that goes on from episode to episode."""
    return {"time": perception.time, "items": perception.items}


class Stage:
    """Between two calls the world stands still. One thread."""

    def __init__(self, address: Address, tasks: Mapping[str, Task], frames: int) -> None:
        if frames < 1:
            raise ValueError(f"frames is {frames}; expected 1 or more")
        self._tasks = tasks
        self._frames = frames
        self._frame = 0
        self._control = control(*address, name="-".join(("stage", *tasks))[:64])
        self._agents = {}
        try:
            for name, task in tasks.items():
                self._agents[name] = connect(
                    *address, name=name, body=task.body, time=LockStep(frames, _DEADLINE)
                )
        except BaseException:
            self.close()
            raise

    def reset(self, random: numpy.random.Generator) -> Dict[str, Perception]:
        """Begins the world anew; what is perceived when the tasks' changes have been made, and a step was done."""
        rewound = self._control.rewind()
        if rewound.frame is None:
            raise ReveError(rewound.code or "refused", rewound.reason or "the world cannot begin anew")
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
        """Lets everybody act, and the world go on; what is perceived then."""
        for name, agent in self._agents.items():
            agent.ready(*acts.get(name, ()))
        self._frame += self._frames
        return {name: self._perceived(name, agent.observe(self._frame)) for name, agent in self._agents.items()}

    def _perceived(self, name: str, perception: Perception) -> Perception:
        if perception.frame != self._frame:
            raise ReveError(
                "late",
                f"the world went on to frame {perception.frame} without agent {name}, which was in frame {self._frame}",
                "serve it with a longer --deadline, or think faster",
            )
        for result in perception.results:
            if not result:
                raise ReveError(result.code or "refused", f"an act of {name}: {result.reason}")
        return perception

    def close(self) -> None:
        """Leaves the world. Calling it again does nothing."""
        for client in (*self._agents.values(), self._control):
            client.close()
