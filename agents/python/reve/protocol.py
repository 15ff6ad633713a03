"""The messages of protocol version 1 and how they are written, one JSON object per line.

The protocol is described in agents/protocol/PROTOCOL.md.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

from .errors import ProtocolError

VERSION = 1
AGENT, CONTROL, OBSERVER = "agent", "control", "observer"

Value = Union[str, float, bool, List[float]]
"""A symbol's or an event field's value."""
Argument = Union[str, bool, float, Sequence[float]]
"""An argument of an action, in the unit that the action declares."""
Message = Dict[str, Any]


@dataclass(frozen=True)
class Limits:
    """What the server takes from a client: bytes of a line, commands that wait for their result, silence [s], grace [s]."""

    line_bytes: int
    acts_in_flight: int
    idle_seconds: float
    grace_seconds: float


@dataclass(frozen=True)
class Ticket:
    """With the token another connection goes on with the session, that long [s] after the first broke."""

    token: str
    grace_seconds: float


@dataclass(frozen=True)
class Welcome:
    """The first answer: who you are in which world. `rate` is its frames per second; only agents have a body."""

    id: Optional[int]
    protocol: int
    role: str
    agent: str
    body: Optional[str]
    world: str
    frame: int
    rate: int
    session: Optional[Ticket]
    resumed: bool
    limits: Limits


@dataclass(frozen=True)
class Parameter:
    """What an action takes. `components` and `unit` are given for type "number" only."""

    type: str
    components: Optional[int] = None
    unit: Optional[str] = None


@dataclass(frozen=True)
class Item:
    """One item as perceived. `location` is x, y, z [m] in the world's frame, None for what has no place."""

    name: str
    location: Optional[Tuple[float, float, float]]
    symbols: Mapping[str, Value]
    actions: Mapping[str, Mapping[str, Parameter]]


@dataclass(frozen=True)
class Perception:
    """All items of one frame; `time` is the world's [s]."""

    id: Optional[int]
    frame: int
    time: float
    items: Tuple[Item, ...]

    def find(self, name: str) -> Optional[Item]:
        """The item of that name, if it was perceived."""
        return next((item for item in self.items if item.name == name), None)


@dataclass(frozen=True)
class Result:
    """How an act ended: the frame it took effect in, or a code and a reason. True where accepted."""

    id: int
    accepted: bool
    frame: Optional[int] = None
    code: Optional[str] = None
    reason: Optional[str] = None

    def __bool__(self) -> bool:
        return self.accepted


@dataclass(frozen=True)
class Event:
    """Something happened in the world in that frame."""

    frame: int
    type: str
    fields: Mapping[str, Value]


@dataclass(frozen=True)
class Error:
    """A message was refused; the connection goes on."""

    id: Optional[int]
    code: str
    message: str
    hint: Optional[str]


@dataclass(frozen=True)
class Ping:
    """The server asks whether we are still there."""

    id: Optional[int]


@dataclass(frozen=True)
class Pong:
    """The server is still there."""

    id: Optional[int]


@dataclass(frozen=True)
class Bye:
    """The connection ends, and why."""

    id: Optional[int]
    code: str
    message: str
    hint: Optional[str]


ServerMessage = Union[Welcome, Perception, Result, Event, Error, Ping, Pong, Bye]


def hello(
    name: str,
    body: Optional[str] = None,
    role: str = AGENT,
    grace_seconds: float = 0,
    resume: Optional[Tuple[str, int]] = None,
) -> Message:
    """`resume` is the token of a session and the last frame whose events have all come."""
    message: Message = {"t": "hello", "protocol": VERSION, "name": name}
    if role != AGENT:
        message["role"] = role
    if body is not None:
        message["body"] = body
    if grace_seconds > 0:
        message["graceSeconds"] = grace_seconds
    if resume is not None:
        message["resume"] = {"session": resume[0], "frame": resume[1]}
    return message


def perceive(id: int, every: Optional[int] = None, relations: bool = False) -> Message:
    message: Message = {"t": "perceive", "id": id}
    if every is not None:
        message["every"] = every
    if relations:
        message["relations"] = True
    return message


def act(id: int, item: str, action: str, arguments: Mapping[str, Argument]) -> Message:
    return {"t": "act", "id": id, "item": item, "action": action, "arguments": dict(arguments)}


def command(id: int, t: str, **fields: Any) -> Message:
    """What only the role control may say."""
    return {"t": t, "id": id, **fields}


def ping(id: int) -> Message:
    return {"t": "ping", "id": id}


def pong() -> Message:
    return {"t": "pong"}


def bye() -> Message:
    return {"t": "bye"}


def encode(message: Message) -> bytes:
    """One line with its end. ValueError for a number that is not finite, TypeError for what JSON has no form of."""
    text = json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode("utf-8") + b"\n"


def decode(line: bytes) -> ServerMessage:
    """The message that a line from the server says; ProtocolError if it says none."""
    try:
        message = json.loads(line.decode("utf-8"))
        return _READERS[message["t"]](message)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        shown = line[:200].decode("utf-8", "backslashreplace").rstrip()
        raise ProtocolError(f"the server sent {shown!r}, which is no message ({error!r})") from error


def _welcome(message: Message) -> Welcome:
    limits, session = message["limits"], message.get("session")
    return Welcome(
        id=message.get("id"),
        protocol=message["protocol"],
        role=message["role"],
        agent=message["agent"],
        body=message.get("body"),
        world=message["world"],
        frame=message["frame"],
        rate=message["rate"],
        session=None if session is None else Ticket(session["token"], session["graceSeconds"]),
        resumed=message.get("resumed", False),
        limits=Limits(
            limits["lineBytes"], limits["actsInFlight"], limits["idleSeconds"], limits["graceSeconds"]
        ),
    )


def _item(item: Message) -> Item:
    location: Optional[List[float]] = item.get("location")
    return Item(
        name=item["name"],
        location=None if location is None else (location[0], location[1], location[2]),
        symbols=item["symbols"],
        actions={
            action: {
                name: Parameter(p["type"], p.get("components"), p.get("unit"))
                for name, p in parameters.items()
            }
            for action, parameters in item["actions"].items()
        },
    )


def _perception(message: Message) -> Perception:
    return Perception(
        id=message.get("id"),
        frame=message["frame"],
        time=message["time"],
        items=tuple(_item(item) for item in message["items"]),
    )


def _result(message: Message) -> Result:
    if message["accepted"]:
        return Result(message["id"], True, frame=message["frame"])
    return Result(message["id"], False, code=message["code"], reason=message["reason"])


_READERS: Mapping[str, Callable[[Message], ServerMessage]] = {
    "welcome": _welcome,
    "perception": _perception,
    "result": _result,
    "event": lambda m: Event(m["frame"], m["type"], m["fields"]),
    "error": lambda m: Error(m.get("id"), m["code"], m["message"], m.get("hint")),
    "ping": lambda m: Ping(m.get("id")),
    "pong": lambda m: Pong(m.get("id")),
    "bye": lambda m: Bye(m.get("id"), m["code"], m["message"], m.get("hint")),
}
