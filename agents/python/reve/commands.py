# SPDX-License-Identifier: Apache-2.0
"""The commands of the role control, for blocking and for asynchronous clients."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Generic, Optional, TypeVar, Union

from .protocol import Argument, Item

R = TypeVar("R")
"""The type of a result: Result, or an awaitable Result in the asyncio client."""
Q = TypeVar("Q")
"""The type of a report: Report, or an awaitable Report in the asyncio client."""


class Commands(ABC, Generic[R, Q]):
    """The commands of the role control, and questions about the world. Each command returns a
    result.

    While the world is paused, `edit`, `load_law`, `unload_law` and `picture` wait until its next
    frame.
    """

    def pause(self) -> R:
        """Pauses the world, so that it makes no more frames."""
        return self._command("pause")

    def step(self, frames: int = 1) -> R:
        """Lets a paused world make `frames` frames. The result contains the number of the last
        frame."""
        return self._command("step", frames=frames)

    def run(self) -> R:
        """Lets a paused world continue."""
        return self._command("run")

    def speed(self, factor: float) -> R:
        """Sets the speed of the world, as world time per time of the clock. The factor 2 is double
        speed."""
        return self._command("speed", factor=factor)

    def snapshot(self, image: str) -> R:
        """Keeps the state of the world under a name until the server ends, so that `rewind` can
        restore it.

        The result contains the frame of the state.
        """
        return self._command("snapshot", image=image)

    def rewind(self, image: Optional[str] = None) -> R:
        """Restores a snapshot, or the initial state of the world. The command takes effect at once,
        even while the world is paused.

        The result contains the number of the frame that shows the restored state. Streams of
        perceptions restart with this frame.
        """
        return self._command("rewind", **({} if image is None else {"image": image}))

    def save(self, file: str) -> R:
        """Saves the state of the world as a world file with the name `file`, in the server's folder
        for files.
        """
        return self._command("save", file=file)

    def edit(self, item: Union[str, Item], property: str, value: Argument) -> R:
        """Sets a property such as `physics.velocity` or `semantic.class`, in its own unit."""
        return self._command("edit", item=_name(item), property=property, value=value)

    def add(
        self, *items: Mapping[str, object], prefabs: Optional[Mapping[str, object]] = None
    ) -> R:
        """Adds items, either all of them or none. Each item is described as in a world file, where
        `like` may name a prefab.

        For example `add({"name": "ball", "physical": {"shape": "sphere", "radius": "5 cm"}})`.
        """
        fields: dict[str, object] = {"items": list(items)}
        if prefabs is not None:
            fields["prefabs"] = prefabs
        return self._command("add", **fields)

    def change(self, item: Union[str, Item], **to: object) -> R:
        """Changes fields of an item: `name`, `parent`, `physical`, `physics`, `semantic` or
        `access`, as in a world file. The value `None` removes a field.

        For example `change("spring", physics={"end2": "hook"})`.
        """
        return self._command("change", item=_name(item), to=to)

    def remove(self, item: Union[str, Item], cascade: bool = False) -> R:
        """Removes an item. With `cascade`, also removes all items that refer to it or are attached
        to it."""
        return self._command("remove", item=_name(item), cascade=cascade)

    def rule(self, name: str, rule: Union[str, Mapping[str, object], None]) -> R:
        """Sets a rule (an expression, or a mapping as in a world file); the value None removes the
        rule."""
        return self._command("rule", name=name, rule=rule)

    def batch(self, *changes: Mapping[str, object]) -> R:
        """Makes changes in their order, either all of them or none. Each change is a message
        without id, for example `{"t": "remove", "item": "ball"}`."""
        return self._command("batch", changes=list(changes))

    def release(self, library: str) -> R:
        """Ends the quarantine of a law library, which may then be loaded again. The server
        quarantines libraries that fail."""
        return self._command("release", library=library)

    def profile(self) -> R:
        """Returns a result whose value contains the times of the parts of the frames."""
        return self._command("profile")

    def cluster(self) -> R:
        """Returns a result whose value contains the nodes and worlds of the server's cluster."""
        return self._command("cluster")

    def move_world(self, world: str, node: str) -> R:
        """Moves a world of the cluster to a node (HOST:PORT, as `cluster` lists it), where it
        stays. The node "any" ends such an order: the cluster then chooses the node.

        The result arrives when the order is stored, before the world moves; `cluster` shows when it
        runs on the node. A client of that world is then disconnected with the code `moved`.
        """
        return self._command("move-world", world=world, node=node)

    def drain_node(self, node: str, drained: bool = True) -> R:
        """Moves all worlds of a node to other nodes, and gives the node no more worlds. With
        `drained` False, the node may run worlds again. The result arrives before the worlds move.
        """
        return self._command("drain-node", node=node, drained=drained)

    def add_world(self, text: str, asleep: bool = False) -> R:
        """Adds a world to the cluster. `text` is a world file that refers to no other files. With
        `asleep`, the world makes its first frame when a client joins it.

        The result arrives when the world is stored, before a node runs it; its value contains the
        name of the `world`, and `warnings` about the file. Clients may join the world at this
        server at once, and at other nodes after a second: they wait until a node runs it.
        """
        return self._command("add-world", text=text, asleep=asleep)

    def changes(self) -> R:
        """Returns a result whose value contains all changes since the last call, except changes by
        laws."""
        return self._command("changes")

    def near(
        self,
        location: Sequence[float],
        distance: Optional[float] = None,
        most: Optional[int] = None,
    ) -> R:
        """Returns a result whose value contains the bodies within a distance [m], or the nearest
        bodies."""
        limits = {"distance": distance, "most": most}
        given = {name: limit for name, limit in limits.items() if limit is not None}
        return self._command("near", location=list(location), **given)

    def region(self, low: Sequence[float], high: Sequence[float]) -> R:
        """Returns a result whose value contains the bodies in a box. Two corners define the box
        [m]."""
        return self._command("region", **{"from": list(low), "to": list(high)})

    def load_law(
        self,
        library: Optional[str] = None,
        *,
        text: Optional[str] = None,
        swap: Optional[str] = None,
        **parameters: Union[float, Sequence[float]],
    ) -> R:
        """Loads a law library that the server knows by its name, or a law as text.

        A text replaces a loaded text of the same name; `library` names it in messages. A library in
        native code or in Python replaces a loaded library of its name if its file has changed.
        Parameters are in SI units; three numbers set a vector. The value "shadow" of `swap` makes the new version first act in
        a copy of the world. The value "at-once" makes it act in the world at once.
        """
        fields: dict[str, Argument] = {} if library is None else {"library": library}
        if text is not None:
            fields["text"] = text
        if swap is not None:
            fields["swap"] = swap
        return self._command("load-law", **fields, parameters=parameters)

    def set_law(
        self,
        library: str,
        *,
        swap: Optional[str] = None,
        **parameters: Union[float, Sequence[float]],
    ) -> R:
        """Changes parameters of a loaded law library, in SI units. Other parameters keep their
        values. With `swap="shadow"`, the new values first act in a copy of the world. With
        `swap="at-once"`, they take effect in the next frame. Without `swap`, the option `--swap` of
        the server decides.
        """
        fields: dict[str, Argument] = {} if swap is None else {"swap": swap}
        return self._command("set-law", library=library, **fields, parameters=parameters)

    def set_budget(
        self,
        library: str,
        milliseconds: Optional[float] = None,
        frames: Optional[int] = None,
        then: Optional[str] = None,
        every: Optional[int] = None,
    ) -> R:
        """Sets the computing time that a loaded law library may take in a frame (its budget).

        `then` is the reaction if the library takes more time in `frames` successive frames: "warn",
        "unload", or "skip-steps", which evaluates force laws in every `every`-th step only. Without
        `milliseconds`, removes the budget of the library.
        """
        fields = {"milliseconds": milliseconds, "frames": frames, "then": then, "every": every}
        given: dict[str, Argument] = {
            name: field for name, field in fields.items() if field is not None
        }
        return self._command("set-budget", library=library, **given)

    def unload_law(self, library: str) -> R:
        return self._command("unload-law", library=library)

    def picture(self) -> R:
        """Saves a picture of the next frame in the server's folder for pictures.

        The result's `value["file"]` is the name of the file in this folder.
        """
        return self._command("picture")

    def state(self, round_trips: bool = False) -> Q:
        """Returns the state of the frame loop, its times, the snapshots and the clients.

        The roles observer and control may call `state`, `inspect`, `search`, `perceived` and
        `laws`. With `round_trips`, for the role control, the server also sends a ping to each
        client. Later reports contain the time `roundTripSeconds` until the client's answer.
        """
        return self._report("state", **({"roundTrips": True} if round_trips else {}))

    def inspect(self, item: Union[str, Item]) -> Q:
        """Returns the four aspects of an item, with units."""
        return self._report("inspect", item=_name(item))

    def search(self, text: str) -> Q:
        """Returns the items whose names or symbols contain a text."""
        return self._report("search", text=text)

    def perceived(self, client: str) -> Q:
        """Returns the items that an agent perceived last."""
        return self._report("perceived", client=client)

    def laws(self) -> Q:
        """Returns the loaded laws with the properties that they use, units, parameters and times,
        the laws in quarantine, and the names that `load_law` knows."""
        return self._report("laws")

    def ledger(self, open: Optional[bool] = None) -> Q:
        """Returns the ledger: the energy and the momentum that each law added since the ledger was
        opened. `open` True opens or restarts the ledger, False closes it.
        """
        return self._report("ledger", **({} if open is None else {"open": open}))

    def audit(
        self, client: Optional[str] = None, frequent: bool = False, most: Optional[int] = None
    ) -> Q:
        """Returns the newest records of the audit log about the world, the newest first.

        `client` selects the records of one client, and `most` (1 to 200) limits their number. With
        `frequent`, the report also contains perceptions, reports, pings and pongs.
        """
        fields = {"client": client, "frequent": frequent or None, "most": most}
        given = {name: field for name, field in fields.items() if field is not None}
        return self._report("audit", **given)

    def shut_down(self) -> R:
        """Ends the server."""
        return self._command("shut-down")

    @abstractmethod
    def _command(self, t: str, **fields: object) -> R: ...

    @abstractmethod
    def _report(self, t: str, **fields: object) -> Q: ...


def _name(item: Union[str, Item]) -> str:
    return item if isinstance(item, str) else item.name
