# SPDX-License-Identifier: Apache-2.0
"""The messages of protocol version 1 and their encodings: JSON lines or MessagePack.

agents/protocol/PROTOCOL.md describes the protocol.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import math
from array import array
from dataclasses import dataclass, field
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    Union,
)

from .errors import ProtocolError, ReveError

VERSION = 1
AGENT, CONTROL, OBSERVER = "agent", "control", "observer"
JSON, MSGPACK = "json", "msgpack"
NOT_TURNED = (0.0, 0.0, 0.0, 1.0)
SAY = "say"
"""The act with which an agent speaks."""
HEARD = "heard"
"""The type of the event that contains what an agent hears."""

MOST_BYTES = 1 << 30
"""Maximum length of a message [bytes]."""
MOST_BYTES_BEFORE_WELCOME = 1 << 20
"""Maximum length of the welcome and of the messages before it [bytes]."""

Value = Union[str, float, bool, List[float]]
"""The value of a symbol or of an event's field."""
Argument = Union[str, bool, float, Sequence[float]]
"""An argument of an action, in the unit that the action declares."""
Message = Dict[str, Any]

# The exceptions that decoding raises if the bytes are no message.
_NO_MESSAGE = (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError)


@dataclass(frozen=True)
class Limits:
    """The server's limits for a client; None if the server has no such limit.

    The fields are, in their order:
    - bytes of a line;
    - messages per second of the clock, or of world time if world time is faster;
    - commands that wait for their result;
    - silence [s] after which the server sends a ping;
    - maximum grace [s];
    - items that exist at the same time and were created by actions of this agent;
    - the same items, created by actions of all agents;
    - bytes of events that actions of this agent raise, per second of world time;
    - the same bytes, raised by actions of all agents.
    """

    line_bytes: int
    messages_per_second: int
    acts_in_flight: int
    idle_seconds: float
    grace_seconds: float
    items: Optional[int] = None
    world_items: Optional[int] = None
    event_bytes: Optional[int] = None
    world_event_bytes: Optional[int] = None


@dataclass(frozen=True)
class Ticket:
    """The token with which a new connection resumes the session. The session can be resumed within
    `grace_seconds` after the old connection broke. `servers` are the addresses of other servers of
    a cluster at which the session can be resumed if this one does not answer.
    """

    token: str
    grace_seconds: float
    servers: Tuple[Tuple[str, int], ...] = ()


@dataclass(frozen=True)
class Act:
    """An action of an item with its arguments; the item None is the agent's own body."""

    item: Optional[str]
    action: str
    arguments: Mapping[str, Argument] = field(default_factory=dict)

    @staticmethod
    def say(text: str) -> Act:
        """Returns the act with which the agent says `text`, for `step`, `ready` and `LockStep`."""
        return Act(None, SAY, {"text": text})


@dataclass(frozen=True)
class LockStep:
    """Settings of lock-step. The world waits for the agent after every `every`th frame, at most for
    `deadline` [s]. The agent's body performs the act `fallback` if the agent has not answered by
    then. With `relations`, the items' symbols also contain `near`, `on`, `inside` and `touching`.
    """

    every: int = 1
    deadline: float = 1.0
    fallback: Optional[Act] = None
    relations: bool = False


@dataclass(frozen=True)
class Welcome:
    """The first answer: the agent's name and world.

    `rate` is the world's frames per second. Only agents have a body. In lock-step, `time` contains
    the interval and the deadline that the server grants. `cameras` are the names of the cameras of
    the agent's body.
    """

    id: Optional[int]
    protocol: int
    role: str
    agent: str
    body: Optional[str]
    world: str
    frame: int
    rate: int
    encoding: str
    time: Optional[LockStep]
    session: Optional[Ticket]
    resumed: bool
    limits: Limits
    cameras: Tuple[str, ...] = ()


@dataclass(frozen=True)
class Parameter:
    """A parameter of an action.

    The fields after the type are for "number" only. They are the count of numbers, their unit, and
    the bounds of each number, if there are any.
    """

    type: str
    components: Optional[int] = None
    unit: Optional[str] = None
    min: Optional[float] = None
    max: Optional[float] = None


@dataclass(frozen=True)
class Item:
    """One item as perceived.

    `location` is x, y, z [m] in the world's reference frame, and `orientation` a unit quaternion x,
    y, z, w. `location` is None for an item without a place, or if no sensor reaches it. `needs`
    contains the capabilities that the acting body must have, for each action that requires any.
    `capabilities` are the capabilities of the item itself.
    """

    name: str
    location: Optional[Tuple[float, float, float]]
    symbols: Mapping[str, Value]
    actions: Mapping[str, Mapping[str, Parameter]]
    orientation: Tuple[float, float, float, float] = NOT_TURNED
    needs: Mapping[str, Sequence[str]] = field(default_factory=dict)
    capabilities: Tuple[str, ...] = ()

    def is_a(self, item_class: str) -> bool:
        """Returns whether the item belongs to a class: its own class, or one above it.

        Returns False if no sensor perceives the symbols `class` and `classes`.
        """
        classes = self.symbols.get("classes", ())
        return item_class == self.symbols.get("class") or (
            isinstance(classes, (list, tuple)) and item_class in classes
        )


@dataclass(frozen=True)
class Reading:
    """The numbers that an instrument of the agent's body measured in `frame`.

    `quantities` contains arrays of 64-bit floats by name; `reading["specificForce"]` is one of
    them. numpy reads such an array without a copy: `numpy.asarray(reading["specificForce"])`.

    | instrument | quantity | shape and unit |
    |---|---|---|
    | `imu` | `specificForce` | (3,) [m/s²], in the body's own axes: acceleration minus gravity |
    | `imu` | `angularVelocity` | (3,) [rad/s], in the body's own axes |
    | `contactForce` | `force` | (3,) [N], in the axes of the world, or of the body |
    | `lidar` | `distances` | (rows * columns,) [m], row by row; `math.inf` where nothing was met |
    | `java` | those that its plugin declares | (components,) in the units of the plugin |

    `columns` is the number of rays side by side of a lidar, and None for other instruments:
    `numpy.asarray(reading["distances"]).reshape(-1, reading.columns)`.
    """

    frame: int
    quantities: Mapping[str, array[float]]
    columns: Optional[int] = None

    def __getitem__(self, quantity: str) -> array[float]:
        """Returns a measured quantity; KeyError if the instrument does not measure it."""
        return self.quantities[quantity]


@dataclass(frozen=True)
class Heard:
    """The part that the agent heard of a text that another agent said in a frame.

    In `text`, "…" replaces each of the `lost` words. `speaker` is the name of the speaker's body,
    or None if no sensor of the hearer senses this body. `direction` is the unit vector from the
    hearer to the speaker, in the world's reference frame (0, 0, 0 at the same place), and
    `distance` the distance [m].
    """

    frame: int
    text: str
    speaker: Optional[str]
    direction: Tuple[float, float, float]
    distance: float
    lost: int = 0


@dataclass(frozen=True)
class Perception:
    """All items that the client perceives in one frame; `time` is the world time [s].

    In lock-step, `results` are the results of the acts of the previous round, in order. `readings`
    are the newest readings of the instruments of the agent's body, by the name of the sensor.
    `heard` contains the texts that the agent has heard since the previous perception, in order, at
    most the last 1,024.
    """

    id: Optional[int]
    frame: int
    time: float
    items: Tuple[Item, ...]
    results: Tuple[Result, ...] = ()
    readings: Mapping[str, Reading] = field(default_factory=dict)
    heard: Tuple[Heard, ...] = ()

    def find(self, name: str) -> Optional[Item]:
        """Returns the item of that name; None if it was not perceived."""
        return next((item for item in self.items if item.name == name), None)

    def __getitem__(self, name: str) -> Item:
        """Returns the item of that name; KeyError if it was not perceived."""
        item = self.find(name)
        if item is None:
            raise KeyError(f"no item {name!r} was perceived in frame {self.frame}")
        return item

    def updated(self, update: Update) -> Perception:
        """Returns this perception with an update applied."""
        if update.since != self.frame:
            raise ProtocolError(f"an update to frame {update.since} came after frame {self.frame}")
        items = {item.name: item for item in self.items}
        for name in update.left:
            items.pop(name, None)
        items.update((item.name, item) for item in update.entered)
        for change in update.changed:
            if change.name not in items:
                raise ProtocolError(f"{change.name!r} changed, which we do not perceive")
            changed = {k: v for k, v in vars(change).items() if v is not None}
            items[change.name] = dataclasses.replace(items[change.name], **changed)
        return Perception(
            id=update.id,
            frame=update.frame,
            time=update.time,
            items=tuple(items.values()),
            readings={**self.readings, **update.readings},
        )


@dataclass(frozen=True)
class Change:
    """The changes of an item. A field that did not change is None."""

    name: str
    location: Optional[Tuple[float, float, float]] = None
    orientation: Optional[Tuple[float, float, float, float]] = None
    symbols: Optional[Mapping[str, Value]] = None
    actions: Optional[Mapping[str, Mapping[str, Parameter]]] = None
    needs: Optional[Mapping[str, Sequence[str]]] = None


@dataclass(frozen=True)
class Update:
    """The difference from the perception of frame `since`."""

    id: Optional[int]
    frame: int
    time: float
    since: int
    left: Tuple[str, ...]
    entered: Tuple[Item, ...]
    changed: Tuple[Change, ...]
    readings: Mapping[str, Reading] = field(default_factory=dict)


@dataclass(frozen=True)
class Result:
    """The result of an act: the frame in which it took effect, or a code and a reason for its
    refusal. As a truth value, a result is True if the act was accepted. After a question, `value`
    is the answer.
    """

    id: int
    accepted: bool
    frame: Optional[int] = None
    code: Optional[str] = None
    reason: Optional[str] = None
    value: Any = None

    def __bool__(self) -> bool:
        return self.accepted


@dataclass(frozen=True)
class Image:
    """A camera's picture, row by row from the top; numbers are little-endian.

    `colour` is red, green and blue in sRGB, one byte each. `depth` [m] is 32-bit floats, the
    distance along the view axis; it is 0 if no surface is in range. `items` is 16 bits, 0 for no
    item, otherwise the index in `names`, from 1. Layers that the camera lacks are None. With numpy:
    `numpy.frombuffer(image.colour, "u1").reshape(image.height, image.width, 3)`, `"<f4"` for the
    depth and `"<u2"` for the items.
    """

    id: int
    frame: int
    time: float
    sensor: str
    width: int
    height: int
    colour: Optional[bytes] = None
    depth: Optional[bytes] = None
    items: Optional[bytes] = None
    names: Tuple[str, ...] = ()

    def find(self, x: int, y: int) -> Optional[str]:
        """Returns the name of the item at that pixel, counted from the upper left; None for no
        item."""
        if self.items is None:
            raise ValueError(f"the camera {self.sensor} does not tell items")
        at = 2 * (y * self.width + x)
        number = int.from_bytes(self.items[at : at + 2], "little")
        return self.names[number - 1] if number > 0 else None


@dataclass(frozen=True)
class Report:
    """The answer to a question about the world; `of` is the type of the question."""

    id: int
    frame: int
    of: str
    content: Mapping[str, Any]


@dataclass(frozen=True)
class Event:
    """An event in the world in that frame."""

    frame: int
    type: str
    fields: Mapping[str, Value]


@dataclass(frozen=True)
class Error:
    """A refused message; the connection remains open."""

    id: Optional[int]
    code: str
    message: str
    hint: Optional[str]


@dataclass(frozen=True)
class Ping:
    """The server's question whether the client still responds."""

    id: Optional[int]


@dataclass(frozen=True)
class Pong:
    """The server's answer to a ping."""

    id: Optional[int]


@dataclass(frozen=True)
class Bye:
    """The end of the connection, and its reason.

    `address` is the address of the server that has the world, if it is another server.
    """

    id: Optional[int]
    code: str
    message: str
    hint: Optional[str]
    address: Optional[Tuple[str, int]] = None


ServerMessage = Union[
    Welcome, Perception, Update, Image, Report, Result, Event, Error, Ping, Pong, Bye
]


def hello(
    name: str,
    body: Optional[str] = None,
    role: str = AGENT,
    encoding: str = JSON,
    grace_seconds: float = 0,
    resume: Optional[Tuple[str, int]] = None,
    token: Optional[str] = None,
    time: Optional[LockStep] = None,
    world: Optional[str] = None,
) -> Message:
    """Returns the first message; `resume` is a session's token and the last frame whose events are
    complete."""
    message: Message = {"t": "hello", "protocol": VERSION, "name": name}
    if role != AGENT:
        message["role"] = role
    if world is not None:
        message["world"] = world
    if body is not None:
        message["body"] = body
    if encoding != JSON:
        message["encoding"] = encoding
    if time is not None:
        message["time"] = _time(time)
    if grace_seconds > 0:
        message["graceSeconds"] = grace_seconds
    if resume is not None:
        message["resume"] = {"session": resume[0], "frame": resume[1]}
    if token is not None:
        message["token"] = token
    return message


def ask(question: str, name: str, token: Optional[str] = None) -> Message:
    """Returns the first message of a client of the role control that asks a question instead of
    joining a world. The answer is a Result with the id 1."""
    return {**hello(name, role=CONTROL, token=token), "id": 1, "ask": question}


def _time(time: LockStep) -> Message:
    message: Message = {"mode": "lock-step"}
    if time.every != 1:
        message["every"] = time.every
    if time.relations:
        message["relations"] = True
    if time.deadline != 1.0:
        message["deadline"] = time.deadline
    if time.fallback is not None:
        act = time.fallback
        message["fallback"] = {"action": act.action, "arguments": dict(act.arguments)}
        if act.item is not None:
            message["fallback"]["item"] = act.item
    return message


def perceive(id: int, every: Optional[int] = None, relations: bool = False) -> Message:
    message: Message = {"t": "perceive", "id": id}
    if every is not None:
        message["every"] = every
    if relations:
        message["relations"] = True
    return message


def look(id: int, sensor: str, item: Optional[str] = None) -> Message:
    """Returns the message `look`. `item` is the body that carries the camera; None is the agent's
    own body."""
    message: Message = {"t": "look", "id": id, "sensor": sensor}
    return message if item is None else {**message, "item": item}


def act(id: int, item: str, action: str, arguments: Mapping[str, Argument]) -> Message:
    return {"t": "act", "id": id, "item": item, "action": action, "arguments": dict(arguments)}


def ready(frame: Optional[int] = None) -> Message:
    """Returns the message `ready`. `frame` is the frame of the perception on which the agent's
    decision is based."""
    return {"t": "ready"} if frame is None else {"t": "ready", "frame": frame}


def and_ready(act: Message, frame: Optional[int] = None) -> Message:
    """Returns an act that also contains `ready`."""
    return {**act, **ready(frame), "t": "act", "ready": True}


def command(id: int, t: str, **fields: Any) -> Message:
    """Returns a command, which only the role control may send."""
    return {"t": t, "id": id, **fields}


def ping(id: int) -> Message:
    return {"t": "ping", "id": id}


def pong() -> Message:
    return {"t": "pong"}


def bye() -> Message:
    return {"t": "bye"}


def encode(message: Message, encoding: str = JSON) -> bytes:
    """Returns the message as sent over the connection.

    Raises ValueError for a number that is not finite, TypeError for a value that JSON cannot
    represent.
    """
    if encoding == JSON:
        text = json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        return text.encode("utf-8") + b"\n"
    _require_finite(message)
    packed: bytes = _msgpack().packb(message)
    return len(packed).to_bytes(4, "big") + packed


def decode(line: bytes) -> ServerMessage:
    """Decodes a line from the server; raises ProtocolError if it is not a message."""
    try:
        return _message(json.loads(line.decode("utf-8")))
    except _NO_MESSAGE as error:
        shown = line[:200].decode("utf-8", "backslashreplace").rstrip()
        raise ProtocolError(
            f"the server sent {shown!r}, which is no message ({error!r})"
        ) from error


def decode_packed(message: bytes) -> ServerMessage:
    """Decodes a MessagePack message without its length prefix; raises ProtocolError if it is not a
    message."""
    try:
        return _message(_msgpack().unpackb(message))
    except _NO_MESSAGE as error:
        raise ProtocolError(
            f"the server sent {message[:200].hex()}, which is no message ({error!r})"
        ) from error


class Incoming:
    """Splits the received bytes of one connection into messages, in either encoding. For one
    thread.

    A message may have at most `limit` bytes. The limit is small before the welcome. A program that
    is no server therefore cannot make the client store an unlimited number of bytes.
    """

    def __init__(self, encoding: str) -> None:
        self.limit = MOST_BYTES_BEFORE_WELCOME
        self._packed = encoding == MSGPACK
        self._bytes = bytearray()
        self._start = 0  # start of the next message
        self._searched = 0  # position up to which the end of this message was searched

    def feed(self, data: bytes) -> None:
        """Appends received bytes, which may contain several messages and parts of messages."""
        if self._start > 0:
            del self._bytes[: self._start]
            self._searched -= self._start
            self._start = 0
        self._bytes += data

    def next(self) -> Optional[ServerMessage]:
        """Returns the next message, or None if it is incomplete. Raises ProtocolError if it is
        invalid or too long."""
        first = self._bytes[self._start : self._start + 1]
        if self._packed and first and first != b"{":  # a length below 2^30, not a line
            length = self._length()
            self._require(length)
            message = self._take(self._start + 4 + length)
            return None if message is None else decode_packed(message[4:])
        end = self._bytes.find(b"\n", max(self._searched, self._start)) + 1
        self._searched = len(self._bytes)
        self._require((end or len(self._bytes)) - self._start)
        line = self._take(end) if end > 0 else None
        return None if line is None else decode(line)

    def _require(self, length: int) -> None:
        if length > self.limit:
            begin = bytes(self._bytes[self._start : self._start + 40])
            raise ProtocolError(
                f"the server sent a message of {length} bytes or more that begins with {begin!r}, "
                f"expected at most {self.limit} bytes"
            )

    def _length(self) -> int:
        """Returns the length of the next message behind its prefix. If the prefix is incomplete,
        the number is too small, and `_take` waits for more bytes."""
        return int.from_bytes(self._bytes[self._start : self._start + 4], "big")

    def _take(self, end: int) -> Optional[bytes]:
        if end > len(self._bytes):
            return None
        message = bytes(self._bytes[self._start : end])
        self._start = self._searched = end
        return message


def _message(message: Message) -> ServerMessage:
    return _READERS[message["t"]](message)


def _msgpack() -> Any:
    try:
        import msgpack
    except ImportError as error:
        raise ReveError(
            "no-msgpack",
            "MessagePack needs the package msgpack",
            "pip install msgpack, or use JSON",
        ) from error
    return msgpack


def _require_finite(value: Any) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{value} is not finite")
    if isinstance(value, dict):
        value = value.values()
    if not isinstance(value, (str, bytes)) and isinstance(value, Iterable):
        for element in value:
            _require_finite(element)


def _ticket(session: Message) -> Ticket:
    servers = tuple(_host_and_port(each) for each in session.get("servers", ()))
    return Ticket(session["token"], session["graceSeconds"], servers)


def _welcome(message: Message) -> Welcome:
    limits, session, time = message["limits"], message.get("session"), message.get("time")
    return Welcome(
        id=message.get("id"),
        protocol=message["protocol"],
        role=message["role"],
        agent=message["agent"],
        body=message.get("body"),
        world=message["world"],
        frame=message["frame"],
        rate=message["rate"],
        encoding=message.get("encoding", JSON),
        time=None if time is None else LockStep(time["every"], time["deadline"]),
        session=None if session is None else _ticket(session),
        resumed=message.get("resumed", False),
        limits=Limits(
            limits["lineBytes"],
            limits["messagesPerSecond"],
            limits["actsInFlight"],
            limits["idleSeconds"],
            limits["graceSeconds"],
            limits.get("items"),
            limits.get("worldItems"),
            limits.get("eventBytes"),
            limits.get("worldEventBytes"),
        ),
        cameras=tuple(message.get("cameras", ())),
    )


def _item(item: Message) -> Item:
    change = _change(item)
    return Item(
        name=change.name,
        location=change.location,
        symbols=change.symbols or {},
        actions=change.actions or {},
        orientation=change.orientation or NOT_TURNED,
        needs=change.needs or {},
        capabilities=tuple(item.get("capabilities", ())),
    )


def _change(item: Message) -> Change:
    at: Optional[List[float]] = item.get("location")
    turn: Optional[List[float]] = item.get("orientation")
    actions: Optional[Message] = item.get("actions")
    return Change(
        name=item["name"],
        location=None if at is None else (at[0], at[1], at[2]),
        orientation=None if turn is None else (turn[0], turn[1], turn[2], turn[3]),
        symbols=item.get("symbols"),
        actions=None
        if actions is None
        else {
            action: {
                name: Parameter(
                    p["type"], p.get("components"), p.get("unit"), p.get("min"), p.get("max")
                )
                for name, p in parameters.items()
            }
            for action, parameters in actions.items()
        },
        needs=item.get("needs"),
    )


def _perception(message: Message) -> Union[Perception, Update]:
    if "since" not in message:
        items = tuple(_item(item) for item in message["items"])
        return Perception(
            id=message.get("id"),
            frame=message["frame"],
            time=message["time"],
            items=items,
            readings=_readings(message),
        )
    return Update(
        id=message.get("id"),
        frame=message["frame"],
        time=message["time"],
        since=message["since"],
        left=tuple(message.get("left", ())),
        entered=tuple(_item(item) for item in message.get("entered", ())),
        changed=tuple(_change(item) for item in message.get("changed", ())),
        readings=_readings(message),
    )


def _readings(message: Message) -> Mapping[str, Reading]:
    return {
        sensor: Reading(
            frame=reading["frame"],
            quantities={
                name: array("d", _distances(numbers) if name == "distances" else numbers)
                for name, numbers in reading.items()
                if isinstance(numbers, list)
            },
            columns=reading.get("columns"),
        )
        for sensor, reading in message.get("readings", {}).items()
    }


def _distances(numbers: List[float]) -> List[float]:
    return [math.inf if number < 0 else number for number in numbers]


def heard(event: Event) -> Heard:
    """Reads an event `heard`."""
    fields: Mapping[str, Any] = event.fields
    x, y, z = fields["direction"]
    return Heard(
        frame=event.frame,
        text=fields["text"],
        speaker=fields.get("speaker"),
        direction=(x, y, z),
        distance=fields["distance"],
        lost=int(fields.get("lost", 0)),
    )


def _image(message: Message) -> Image:
    return Image(
        id=message["id"],
        frame=message["frame"],
        time=message["time"],
        sensor=message["sensor"],
        width=message["width"],
        height=message["height"],
        colour=_bytes(message.get("colour")),
        depth=_bytes(message.get("depth")),
        items=_bytes(message.get("items")),
        names=tuple(message.get("names", ())),
    )


def _bytes(value: Union[str, bytes, None]) -> Optional[bytes]:
    return base64.b64decode(value, validate=True) if isinstance(value, str) else value


def _report(message: Message) -> Report:
    return Report(message["id"], message["frame"], message["of"], dict(message["content"]))


def _result(message: Message) -> Result:
    if message["accepted"]:
        return Result(message["id"], True, frame=message["frame"], value=message.get("value"))
    return Result(message["id"], False, code=message["code"], reason=message["reason"])


def _address(text: Optional[str]) -> Optional[Tuple[str, int]]:
    """Reads HOST:PORT."""
    return None if text is None else _host_and_port(text)


def _host_and_port(text: str) -> Tuple[str, int]:
    host, _, port = text.rpartition(":")
    return host, int(port)


_READERS: Mapping[str, Callable[[Message], ServerMessage]] = {
    "welcome": _welcome,
    "perception": _perception,
    "image": _image,
    "report": _report,
    "result": _result,
    "event": lambda m: Event(m["frame"], m["type"], m["fields"]),
    "error": lambda m: Error(m.get("id"), m["code"], m["message"], m.get("hint")),
    "ping": lambda m: Ping(m.get("id")),
    "pong": lambda m: Pong(m.get("id")),
    "bye": lambda m: Bye(
        m.get("id"), m["code"], m["message"], m.get("hint"), _address(m.get("address"))
    ),
}
