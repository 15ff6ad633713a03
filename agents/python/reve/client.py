"""A blocking client. One thread of its own reads, so pings are answered while the agent thinks."""

from __future__ import annotations

import itertools
import socket
import threading
import time
from collections import deque
from typing import (
    BinaryIO,
    Callable,
    Deque,
    Dict,
    Iterator,
    List,
    Optional,
    Set,
    Tuple,
    Type,
    TypeVar,
    Union,
)

from . import protocol
from .errors import Disconnected, ProtocolError, ReveError
from .tls import Tls, TlsSocket, secure
from .protocol import (
    Argument,
    Bye,
    Error,
    Event,
    Image,
    Item,
    Message,
    Perception,
    Ping,
    Pong,
    Result,
    ServerMessage,
    Update,
    Welcome,
)

_EVENTS_KEPT = 1024
_RETRY_SECONDS = 0.2

_T = TypeVar("_T")


def connect(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str,
    world: Optional[str] = None,
    body: Optional[str] = None,
    role: str = protocol.AGENT,
    encoding: str = protocol.JSON,
    grace: float = 0.0,
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Agent:
    """Joins the world at that address as agent `name` and returns when it has a body there.

    `world` names one of the server's worlds; needed only where it has several.
    `body` names an item that the world lends to agents; without it the world chooses one. As `role` "observer"
    one perceives everything and does nothing. `encoding` "msgpack" is faster and needs the package msgpack.
    `grace` [s] is how long the body may wait for us when the connection breaks; we reconnect by ourselves, and
    whoever waits for an answer notices nothing. `token` is what a server that asks for one was told to expect.
    `tls` makes the connection private: True trusts whom this machine trusts, the name of a file only the
    certificates in it. `timeout` [s] bounds this and every later wait for an answer.
    Raises OSError where nobody listens, Disconnected with the server's code where the agent may not join.
    """
    greeting = protocol.hello(name, body, role, encoding, grace, token=token, world=world)
    return Agent((host, port), greeting, timeout, tls)


def control(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str = "control",
    world: Optional[str] = None,
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Control:
    """Joins a world to run it, without a body. As for `connect`."""
    greeting = protocol.hello(name, role=protocol.CONTROL, token=token, world=world)
    return Control((host, port), greeting, timeout, tls)


class Agent:
    """An agent in a world, from `connect`. Its methods may be called from any thread.

    Every call raises Disconnected once the connection has ended, and ReveError with code `no-answer` when
    the server is silent for longer than the timeout.
    """

    def __init__(
        self, address: Tuple[str, int], greeting: Message, timeout: float, tls: Tls = False
    ) -> None:
        self._address = address
        self._timeout = timeout
        self._tls = tls
        self._ids = itertools.count(1)
        self._sending = threading.Lock()
        self._changed = threading.Condition()
        self._waiting: Dict[int, Optional[ServerMessage]] = {}
        self._unanswered: Dict[int, bytes] = {}
        self._subscription: Optional[int] = None
        self._every = 0
        self._latest: Optional[Perception] = None
        self._known: Optional[Perception] = None
        self._encoding = str(greeting.get("encoding", protocol.JSON))
        self._events: Deque[Event] = deque(maxlen=_EVENTS_KEPT)
        self._frame_seen = 0
        self._ahead: Set[int] = set()  # ids of questions about frames that are not made yet
        self._seen_after: List[int] = []  # frames of the events that came after the last one seen whole
        self._known_already = 0
        self._end: Optional[ReveError] = None

        self._socket, self._stream, self.welcome = self._open(greeting)
        self._frame_seen = self.welcome.frame - 1
        self._reader = threading.Thread(
            target=self._read, name=f"reve agent {self.welcome.agent}", daemon=True
        )
        self._reader.start()

    def _open(
        self, greeting: Message
    ) -> Tuple[Union[socket.socket, TlsSocket], BinaryIO, Welcome]:
        plain = socket.create_connection(self._address, self._timeout)
        connection: Union[socket.socket, TlsSocket] = plain
        try:
            plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self._tls:
                connection = secure(plain, self._address[0], self._tls)
            stream = connection.makefile("rb")
            connection.sendall(protocol.encode(greeting))
            welcome = _await_welcome(stream)
            connection.settimeout(None)
            return connection, stream, welcome
        except BaseException:
            connection.close()
            raise

    @property
    def name(self) -> str:
        return self.welcome.agent

    @property
    def body(self) -> Optional[str]:
        """The name of the item that is this agent's body; only the role "agent" has one."""
        return self.welcome.body

    def perceive(self, relations: bool = False) -> Perception:
        """The items of the next frame.

        With `relations`, the symbols of bodies with a shape hold `near`, `on`, `inside` and `touching`, too.
        """
        return self._ask(lambda id: protocol.perceive(id, relations=relations), Perception)

    def perceptions(self, every: int = 1) -> Iterator[Perception]:
        """A perception every that many frames, always the newest: a slow loop skips, it never lags.

        An agent has one such stream; starting another ends the first.
        """
        if every < 1:
            raise ValueError(f"every is {every}; expected a number of frames, 1 or more")
        number = next(self._ids)
        with self._changed:
            self._subscription, self._every = number, every
            self._latest = self._known = None
        self._send(protocol.perceive(number, every))
        try:
            while True:
                with self._changed:
                    self._wait(
                        lambda: self._subscription != number or self._latest is not None,
                        self._timeout + every / self.welcome.rate,
                    )
                    if self._subscription != number or self._latest is None:
                        return
                    perception, self._latest = self._latest, None
                yield perception
        finally:
            self._unsubscribe(number)

    def look(self, sensor: str) -> Image:
        """What one of our body's cameras sees now; ReveError with the server's code if there is no picture."""
        return self._ask(lambda number: protocol.look(number, sensor), Image)

    def act(self, item: Union[str, Item], action: str, /, **arguments: Argument) -> Result:
        """Asks the item to do one of its actions and waits for the outcome.

        A refusal is a result (`accepted` is False, with `code` and `reason`), not an exception.
        """
        target = item if isinstance(item, str) else item.name
        return self._ask(lambda number: protocol.act(number, target, action, arguments), Result)

    def ping(self) -> None:
        """Returns when the server has answered."""
        self._ask(protocol.ping, Pong)

    def events(self) -> List[Event]:
        """What happened since the last call, oldest first; the last 1,024 events are kept."""
        with self._changed:
            events = list(self._events)
            self._events.clear()
        return events

    def close(self) -> None:
        """Leaves the world. Calling it again does nothing."""
        with self._changed:
            if self._end is None:
                self._end = Disconnected("closed", "this agent has left")
                self._changed.notify_all()
        try:
            with self._sending:
                self._socket.sendall(self._encode(protocol.bye()))
            self._reader.join(self._timeout)  # ends with the server's bye, or with the connection
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the connection is gone already, which is all we want
        self._reader.join()
        self._stream.close()
        self._socket.close()

    def __enter__(self) -> Agent:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, question: Callable[[int], Message], answer_type: Type[_T]) -> _T:
        number = next(self._ids)
        line = self._encode(question(number))
        with self._changed:
            self._waiting[number] = None
        try:
            self._send_line(line, number)
            with self._changed:
                self._wait(lambda: self._waiting[number] is not None, self._timeout)
                answer = self._waiting[number]
        finally:
            with self._changed:
                del self._waiting[number]
            with self._sending:
                self._unanswered.pop(number, None)
        if isinstance(answer, Error):
            raise ReveError(answer.code, answer.message, answer.hint)
        if not isinstance(answer, answer_type):
            raise ProtocolError(f"expected {answer_type.__name__} {number}, got {answer}")
        return answer

    def _wait(self, ready: Callable[[], bool], patience: float) -> None:
        """With `_changed` held: until ready, or the end of the connection or of patience [s]."""
        self._changed.wait_for(lambda: self._end is not None or ready(), patience)
        if not ready():
            raise self._end or ReveError(
                "no-answer", f"the server was silent for {patience} s", "is its world running?"
            )

    def _unsubscribe(self, number: int) -> None:
        with self._changed:
            if self._subscription != number:
                return
            self._subscription = self._latest = self._known = None
            if self._end is not None:
                return
        self._send(protocol.perceive(next(self._ids), 0))

    def _encode(self, message: Message) -> bytes:
        return protocol.encode(message, self._encoding)

    def _send(self, message: Message) -> None:
        self._send_line(self._encode(message))

    def _send_line(self, line: bytes, number: Optional[int] = None) -> None:
        """Sends now or, if the connection is broken but may come back, what has a number later."""
        with self._changed:
            if self._end is not None:
                raise self._end
        with self._sending:
            if number is not None:
                self._unanswered[number] = line
            try:
                self._socket.sendall(line)
            except OSError as error:
                if self.welcome.session is None:
                    self._finish(Disconnected("lost", f"the connection broke: {error}"))
                    with self._changed:
                        raise self._end or error

    def _read(self) -> None:
        end: ReveError = Disconnected("lost", "the server closed the connection without a reason")
        while True:
            try:
                message = protocol.read(self._stream)
                if message is not None:
                    if isinstance(message, Bye):
                        self._finish(Disconnected(message.code, message.message, message.hint))
                        return
                    self._take(message)
                    continue
            except OSError as error:
                end = Disconnected("lost", f"the connection broke: {error}")
            except ReveError as error:
                self._finish(error)
                return
            if not self._resume():
                self._finish(end)
                return

    def _resume(self) -> bool:
        """Goes on over another connection, until the time of grace is over. True if that worked."""
        ticket = self.welcome.session
        if ticket is None or self._end is not None:
            return False
        self._stream.close()
        self._socket.close()
        deadline = time.monotonic() + ticket.grace_seconds
        while time.monotonic() < deadline and self._end is None:
            try:
                self._go_on(ticket.token)
                return True
            except ReveError as error:
                self._finish(error)
                return False
            except OSError:
                with self._changed:
                    self._changed.wait_for(lambda: self._end is not None, _RETRY_SECONDS)
        return False

    def _go_on(self, token: str) -> None:
        greeting = protocol.hello(
            self.name,
            role=self.welcome.role,
            encoding=self._encoding,
            resume=(token, max(0, self._frame_seen)),
            world=self.welcome.world,
        )
        connection, stream, _ = self._open(greeting)
        self._known_already = len(self._seen_after)
        with self._sending:
            self._socket, self._stream = connection, stream
            for line in self._unanswered.values():
                connection.sendall(line)
            with self._changed:
                subscription, every = self._subscription, self._every
            if subscription is not None:
                connection.sendall(self._encode(protocol.perceive(subscription, every)))

    def _take(self, message: ServerMessage) -> None:
        if isinstance(message, Ping):
            self._send(protocol.pong())
            return
        with self._changed:
            if isinstance(message, Event):
                self._hear(message)
            elif isinstance(message, (Perception, Update)) and message.id == self._subscription:
                self._show(message)
                self._has_seen(message.frame)
            elif isinstance(message, (Perception, Image, Result, Pong, Error)):
                self._answer(message)
            self._changed.notify_all()

    def _hear(self, event: Event) -> None:
        if self._known_already > 0:  # told again after a break
            self._known_already -= 1
            return
        self._events.append(event)
        self._has_seen(event.frame - 1)
        self._seen_after.append(event.frame)

    def _has_seen(self, frame: int) -> None:
        """All events up to that frame have come."""
        self._frame_seen = max(self._frame_seen, frame)
        self._seen_after = [f for f in self._seen_after if f > self._frame_seen]

    def _show(self, message: Union[Perception, Update]) -> None:
        if isinstance(message, Perception):
            self._known = message
        elif self._known is not None:
            self._known = self._known.updated(message)
        self._latest = self._known

    def _answer(self, message: Union[Perception, Image, Result, Pong, Error]) -> None:
        if isinstance(message, Perception) and message.id not in self._ahead:
            self._has_seen(message.frame)
        if message.id is not None and message.id in self._waiting:
            self._waiting[message.id] = message
        elif isinstance(message, Error):
            raise ReveError(message.code, message.message, message.hint)

    def _finish(self, end: ReveError) -> None:
        with self._changed:
            if self._end is None:
                self._end = end
            self._changed.notify_all()


class Control(Agent):
    """Runs a world, from `control`: perceives everything, and each call below waits for its result.

    While the world is paused, `edit`, `load_law`, `unload_law` and `picture` wait for its next frame.
    """

    def pause(self) -> Result:
        """Keeps the world from making frames."""
        return self._command("pause")

    def step(self, frames: int = 1) -> Result:
        """Lets a paused world make that many frames; the result names the last of them."""
        return self._command("step", frames=frames)

    def run(self) -> Result:
        """Lets a paused world go on."""
        return self._command("run")

    def snapshot(self, image: str) -> Result:
        """Keeps the world as it is under that name, for `rewind`; the result names the frame it is of."""
        return self._command("snapshot", image=image)

    def rewind(self, image: Optional[str] = None) -> Result:
        """Goes back to a snapshot, or to where the world began, at once, even while it is paused.

        The result names the frame that shows the world as it was. Streams of perceptions begin anew with it.
        """
        return self._command("rewind", **({} if image is None else {"image": image}))

    def save(self, file: str) -> Result:
        """Saves the world as it is as a world file of that name, in the folder that the server was given."""
        return self._command("save", file=file)

    def foresee(self, frames: int) -> Perception:
        """What would be perceived that many frames from now, if nobody did anything.

        ReveError with the server's code if it refuses to look so far ahead.
        """

        def fork(number: int) -> Message:
            self._ahead.add(number)
            return protocol.command(number, "fork", frames=frames)

        answer = self._ask(fork, object)
        if isinstance(answer, Perception):
            return answer
        if isinstance(answer, Result):
            raise ReveError(answer.code or "refused", answer.reason or "the server does not look ahead")
        raise ProtocolError(f"expected a perception, got {answer}")

    def edit(self, item: Union[str, Item], property: str, value: Argument) -> Result:
        """Sets a property such as `physics.velocity` or `semantic.class`, in its own unit."""
        target = item if isinstance(item, str) else item.name
        return self._command("edit", item=target, property=property, value=value)

    def load_law(self, library: str, **parameters: float) -> Result:
        """Loads a library of laws that the server knows by that name; parameters in SI units."""
        return self._command("load-law", library=library, parameters=parameters)

    def unload_law(self, library: str) -> Result:
        return self._command("unload-law", library=library)

    def picture(self) -> Result:
        """Takes a picture of the next frame, into the server's folder for pictures."""
        return self._command("picture")

    def shut_down(self) -> Result:
        """Ends the server."""
        return self._command("shut-down")

    def _command(self, t: str, **fields: object) -> Result:
        return self._ask(lambda number: protocol.command(number, t, **fields), Result)


def _await_welcome(stream: BinaryIO) -> Welcome:
    """Before the welcome the server may only ping, refuse the hello or end the connection."""
    while True:
        try:
            message = protocol.read(stream)
        except socket.timeout as error:
            raise ReveError(
                "no-answer", "the server did not welcome us in time", "is its world running?"
            ) from error
        if message is None:
            raise Disconnected("lost", "the server closed the connection before its welcome")
        if isinstance(message, Welcome):
            return message
        if isinstance(message, Bye):
            raise Disconnected(message.code, message.message, message.hint)
        if isinstance(message, Error):
            raise ReveError(message.code, message.message, message.hint)
        if not isinstance(message, Ping):
            raise ProtocolError(f"expected a welcome, got {message}")
