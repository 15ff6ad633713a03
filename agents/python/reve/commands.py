# SPDX-License-Identifier: Apache-2.0
"""What runs a world, for clients that wait and for those that do not."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, Optional, TypeVar, Union

from .protocol import Argument, Item

R = TypeVar("R")
"""A Result, or an awaitable one."""


class Commands(ABC, Generic[R]):
    """The commands of the role control. Each has a result.

    While the world is paused, `edit`, `load_law`, `unload_law` and `picture` wait for its next
    frame.
    """

    def pause(self) -> R:
        """Keeps the world from making frames."""
        return self._command("pause")

    def step(self, frames: int = 1) -> R:
        """Lets a paused world make that many frames; the result names the last of them."""
        return self._command("step", frames=frames)

    def run(self) -> R:
        """Lets a paused world go on."""
        return self._command("run")

    def snapshot(self, image: str) -> R:
        """Keeps the world as it is under that name, for `rewind`; the result names the frame it is
        of.
        """
        return self._command("snapshot", image=image)

    def rewind(self, image: Optional[str] = None) -> R:
        """Goes back to a snapshot, or to where the world began, at once, even while it is paused.

        The result names the frame that shows the world as it was. Streams of perceptions begin anew
        with it.
        """
        return self._command("rewind", **({} if image is None else {"image": image}))

    def save(self, file: str) -> R:
        """Saves the world as it is as a world file of that name, in the folder that the server was
        given.
        """
        return self._command("save", file=file)

    def edit(self, item: Union[str, Item], property: str, value: Argument) -> R:
        """Sets a property such as `physics.velocity` or `semantic.class`, in its own unit."""
        target = item if isinstance(item, str) else item.name
        return self._command("edit", item=target, property=property, value=value)

    def load_law(self, library: str, **parameters: float) -> R:
        """Loads a library of laws that the server knows by that name; parameters in SI units."""
        return self._command("load-law", library=library, parameters=parameters)

    def unload_law(self, library: str) -> R:
        return self._command("unload-law", library=library)

    def picture(self) -> R:
        """Takes a picture of the next frame, into the server's folder for pictures."""
        return self._command("picture")

    def shut_down(self) -> R:
        """Ends the server."""
        return self._command("shut-down")

    @abstractmethod
    def _command(self, t: str, **fields: object) -> R: ...
