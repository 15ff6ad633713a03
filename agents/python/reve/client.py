# SPDX-License-Identifier: Apache-2.0
"""A blocking client. A separate thread reads messages, so the client answers pings while the agent
computes."""

from __future__ import annotations

import errno
import socket
import threading
import time as clock
from collections.abc import Mapping
from functools import partial
from typing import (
    Callable,
    Iterator,
    List,
    Optional,
    Sequence,
    Tuple,
    Type,
    TypeVar,
    Union,
)

from . import protocol
from .commands import Commands
from .conversation import CHUNK_BYTES, RETRY_SECONDS, Conversation, Way, result_in, welcome_in
from .errors import (
    Disconnected,
    ReveError,
    broken,
    closed_by_server,
    left,
    not_answered,
    not_welcomed,
    unreadable,
)
from .protocol import (
    Act,
    Argument,
    Event,
    Image,
    Incoming,
    Item,
    LockStep,
    Message,
    Perception,
    Pong,
    Report,
    Result,
    ServerMessage,
    Welcome,
)
from .tls import Tls, TlsSocket, secure

_T = TypeVar("_T")


class _Wire:
    """One connection: sends messages, and yields received ones."""

    def __init__(self, connection: Union[socket.socket, TlsSocket], encoding: str) -> None:
        self.socket = connection
        self._incoming = Incoming(encoding)

    def next(self) -> Optional[ServerMessage]:
        """Returns the next message, or None at the end of the connection."""
        message = self._incoming.next()
        while message is None:
            data = self.socket.recv(CHUNK_BYTES)
            if not data:
                return None
            self._incoming.feed(data)
            message = self._incoming.next()
        return message

    def await_welcome(self) -> Welcome:
        while True:
            welcome = welcome_in(self.next())
            if welcome is not None:
                self._incoming.limit = protocol.MOST_BYTES
                return welcome

    def await_result(self) -> Result:
        """Waits for the answer to a question that takes the place of a welcome."""
        self._incoming.limit = protocol.MOST_BYTES
        while True:
            result = result_in(self.next())
            if result is not None:
                return result


def _dial(address: Tuple[str, int], timeout: float) -> socket.socket:
    try:
        return socket.create_connection(address, timeout)
    except OSError as error:
        host, port = address
        raise type(error)(
            error.errno or errno.ETIMEDOUT,
            f"{host}:{port}: {error.strerror or error}; does a server run there?",
        ) from error


def _open(
    address: Tuple[str, int],
    greeting: Message,
    timeout: float,
    tls: Tls,
    patience: float,
    answer: Callable[[_Wire], _T],
) -> Tuple[_Wire, _T]:
    """Connects, sends the greeting and waits for its answer, at most for `patience` [s]."""
    end = clock.monotonic() + patience
    plain = _dial(address, max(0.01, min(timeout, patience)))
    connection: Union[socket.socket, TlsSocket] = plain
    late = threading.Event()

    def give_up() -> None:
        late.set()
        try:
            plain.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the connection has already ended

    timer = threading.Timer(max(0.0, end - clock.monotonic()), give_up)
    timer.daemon = True
    timer.start()
    try:
        plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if tls:
            connection = secure(plain, address[0], tls)
        wire = _Wire(connection, str(greeting.get("encoding", protocol.JSON)))
        connection.sendall(protocol.encode(greeting))
        found = answer(wire)
        connection.settimeout(None)
        return wire, found
    except BaseException as error:
        connection.close()
        if late.is_set() or isinstance(error, socket.timeout):
            raise not_welcomed() from error
        raise
    finally:
        timer.cancel()


def connect(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str,
    world: Optional[str] = None,
    body: Optional[str] = None,
    role: str = protocol.AGENT,
    encoding: str = protocol.JSON,
    time: Optional[LockStep] = None,
    grace: float = 0.0,
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Agent:
    """Joins the world at an address as agent `name`, and returns when the agent has a body.

    The client joins another server of a cluster if that server has the world. It tries again while
    the cluster starts the world.

    - `world` names one of the server's worlds. It is required only if the server has several.
    - `body` names an item that the world grants to agents. Without it, the world chooses one.
    - `role` "observer" means that the client perceives everything and cannot act.
    - `encoding` "msgpack" is faster and needs the package msgpack.
    - `time` (a LockStep) makes the world wait for the agent; see `Agent.step`. Without it, the
      world runs in real time.
    - `grace` [s] is the time for which the server keeps the body after the connection has broken.
      The client reconnects automatically, and calls that wait for an answer continue to wait. If
      the world moves to another server of a cluster, the client resumes its session there.
    - `token` is the token that the server requires, if any.
    - `tls` encrypts the connection. The value True trusts the authorities of this machine. A file
      name trusts only the certificates in the file.
    - `timeout` [s] limits this call and every later wait for an answer.

    Raises OSError if no server listens at the address, and Disconnected with the server's code if
    the agent may not join.
    """
    if role == protocol.CONTROL:
        raise ValueError('connect() joins agents and observers; use control() for role "control"')
    greeting = protocol.hello(
        name, body, role, encoding, grace, token=token, time=time, world=world
    )
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
    """Joins a world as its controller, without a body. Arguments and exceptions are those of
    `connect`."""
    greeting = protocol.hello(name, role=protocol.CONTROL, token=token, world=world)
    return Control((host, port), greeting, timeout, tls)


def cluster(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str = "control",
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Result:
    """Asks a server for the nodes and worlds of its cluster, without joining a world. A world that
    sleeps continues to sleep.

    The `value` of the result is that of `Control.cluster`. Arguments and exceptions are those of
    `connect`.
    """
    greeting = protocol.ask("cluster", name, token)
    deadline = clock.monotonic() + timeout
    way = Way((host, port))
    while True:
        try:
            patience = deadline - clock.monotonic()
            wire, result = _open((host, port), greeting, timeout, tls, patience, _Wire.await_result)
            wire.socket.close()
            return result
        except Disconnected as error:
            pause = way.after(error)
            if clock.monotonic() + pause > deadline:
                raise
            clock.sleep(pause)


class Client:
    """The common part of agents and controls: a connection, and perceptions. Thread-safe.

    Every call raises Disconnected after the connection has ended, and ReveError with code
    `no-answer` if the server does not answer within the timeout.
    """

    def __init__(
        self, address: Tuple[str, int], greeting: Message, timeout: float, tls: Tls = False
    ) -> None:
        self._address = address
        self._timeout = timeout
        self._tls = tls
        self._sending = threading.Lock()  # a thread that needs both locks acquires this one first
        self._changed = threading.Condition()
        self._wire, welcome = self._follow(greeting, timeout)
        self._talk = Conversation(greeting, welcome)
        self._reader = threading.Thread(
            target=self._read, name=f"reve agent {welcome.agent}", daemon=True
        )
        self._reader.start()

    def _follow(self, greeting: Message, patience: float) -> Tuple[_Wire, Welcome]:
        """Opens a connection to the server that has the world, within `patience` [s]."""
        deadline = clock.monotonic() + patience
        way = Way(self._address)
        while True:
            self._address = way.address
            try:
                return self._open(greeting, deadline - clock.monotonic())
            except (Disconnected, OSError) as error:
                pause = way.after(error)
                if clock.monotonic() + pause > deadline:
                    raise
                clock.sleep(pause)

    def _open(self, greeting: Message, patience: float) -> Tuple[_Wire, Welcome]:
        """Connects and waits for the welcome, at most for `patience` [s]."""
        return _open(
            self._address, greeting, self._timeout, self._tls, patience, _Wire.await_welcome
        )

    @property
    def welcome(self) -> Welcome:
        """The server's first answer, which describes the session."""
        return self._talk.welcome

    @property
    def name(self) -> str:
        return self.welcome.agent

    def perceive(self, relations: bool = False) -> Perception:
        """Returns the items of the next frame.

        With `relations`, the symbols (named facts) of items with a shape also contain `near`, `on`,
        `inside` and `touching`. Each of these lists the names of other items.
        """
        return self._ask(lambda id: protocol.perceive(id, relations=relations), Perception)

    def perceptions(self, every: int = 1) -> Iterator[Perception]:
        """Yields a perception every `every` frames, always the newest one, so a slow loop skips
        frames.

        A client has one such stream. A new stream ends the previous stream.
        """
        with self._sending:
            with self._changed:
                number, line = self._talk.subscribe(every)
            self._send(line)
        patience = self._timeout + every / self.welcome.rate
        try:
            while True:
                with self._changed:
                    self._wait(lambda: self._talk.has_news(number), patience)
                    perception = self._talk.news(number)
                if perception is None:
                    return
                yield perception
        finally:
            with self._sending:
                with self._changed:
                    farewell = self._talk.unsubscribe(number)
                if farewell is not None:
                    self._send(farewell)

    def ping(self) -> None:
        """Sends a ping and returns when the server has answered."""
        self._ask(protocol.ping, Pong)

    def events(self) -> List[Event]:
        """Returns the events since the last call, oldest first; at most the last 1,024 are kept.

        An event `missed` replaces events that the server did not send, because this client reads
        too slowly or other clients caused too many events at once.
        """
        with self._changed:
            return self._talk.events()

    @property
    def missed_events(self) -> int:
        """The minimum number of events that the server did not send, see `missed` in `events`.

        The server may not know the number while the connection was broken. It then counts one
        event.
        """
        return self._talk.missed_events

    def close(self) -> None:
        """Leaves the world. Another call has no effect."""
        self._finish(left())
        try:
            with self._sending:
                self._wire.socket.sendall(self._talk.encode(protocol.bye()))
            self._reader.join(self._timeout)  # the reader ends after the bye or a broken connection
            self._wire.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the connection has already ended
        self._reader.join()
        self._wire.socket.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- requests ----

    def _ask(self, build: Callable[[int], Message], answer_type: Type[_T]) -> _T:
        return self._answer(
            lambda: self._talk.question(build),
            lambda number: self._talk.answer(number, answer_type),
        )

    def _answer(self, question: Callable[[], Tuple[int, bytes]], answer: Callable[[int], _T]) -> _T:
        with self._sending:
            with self._changed:
                number, line = question()
            self._send(line)
        return self._answer_to(number, answer)

    def _answer_to(self, number: int, answer: Callable[[int], _T]) -> _T:
        with self._changed:
            try:
                self._wait(lambda: self._talk.has_answer(number), self._timeout)
                return answer(number)
            finally:
                self._talk.drop(number)

    def _wait(self, ready: Callable[[], bool], patience: float) -> None:
        """Waits, with `_changed` held, until `ready` is true, the connection ends, or `patience`
        [s] has passed."""
        self._changed.wait_for(lambda: self._talk.end is not None or ready(), patience)
        if not ready():
            raise self._talk.end or not_answered(patience)

    def _send(self, lines: bytes) -> None:
        """Sends data, with `_sending` held. Does nothing if the connection is broken.

        The next connection repeats all messages that are still needed.
        """
        try:
            self._wire.socket.sendall(lines)
        except OSError as error:
            if self.welcome.session is None:
                self._finish(broken(error))
                self._talk.require_open()

    def _finish(self, end: ReveError) -> None:
        with self._changed:
            self._talk.finish(end)
            self._changed.notify_all()

    # ---- the reader's thread ----

    def _read(self) -> None:
        try:
            self._read_messages()
        except ReveError as error:
            self._finish(error)
        except Exception as error:  # a message whose fields have wrong types
            self._finish(unreadable(error))

    def _read_messages(self) -> None:
        end: ReveError = closed_by_server()
        while True:
            try:
                message = self._wire.next()
                if message is not None:
                    self._take(message)
                    continue
            except OSError as error:
                end = broken(error)
            except Disconnected as bye:
                self._address = self._talk.next_address(self._address, bye)
                end = bye
            if not self._resume():
                raise end

    def _take(self, message: ServerMessage) -> None:
        with self._changed:
            reply = self._talk.take(message)
            if not isinstance(message, Event):  # no call waits for an event
                self._changed.notify_all()
        if reply is not None:
            with self._sending:
                self._send(reply)

    def _resume(self) -> bool:
        """Reconnects until the time of grace is over. Returns True if the session continues."""
        ticket = self.welcome.session
        if ticket is None:
            return False
        self._wire.socket.close()
        deadline = clock.monotonic() + ticket.grace_seconds
        while clock.monotonic() < deadline:
            with self._changed:
                greeting = self._talk.greeting()
            if greeting is None:
                return False
            try:
                left = deadline - clock.monotonic()
                patience = self._talk.attempt_seconds(self._timeout, left)
                wire, welcome = self._open(greeting, patience)
            except (ReveError, OSError) as error:
                if isinstance(error, ReveError) and not self._talk.may_retry(error):
                    self._finish(error)
                    return False
                self._address = self._talk.another_address(self._address, error)
                with self._changed:
                    self._changed.wait_for(lambda: self._talk.end is not None, RETRY_SECONDS)
                continue
            self._talk.know_servers(welcome)
            with self._sending:
                self._wire = wire
                with self._changed:
                    lines = self._talk.gone_on()
                self._send(lines)
            return True
        return False


class Agent(Client):
    """An agent in a world, created by `connect`."""

    def __enter__(self) -> Agent:
        return self

    @property
    def body(self) -> Optional[str]:
        """The name of the item that is this agent's body; only the role "agent" has one."""
        return self.welcome.body

    def look(self, sensor: str) -> Image:
        """Returns the current picture of a camera of the agent's body.

        Raises ReveError with the server's code if there is no picture.
        """
        return self._ask(lambda number: protocol.look(number, sensor), Image)

    def act(self, item: Union[str, Item], action: str, /, **arguments: Argument) -> Result:
        """Requests an action of the item and waits for its result.

        A refusal is a result (`accepted` is False, with `code` and `reason`), not an exception.
        """
        target = item if isinstance(item, str) else item.name
        return self._ask(lambda number: protocol.act(number, target, action, arguments), Result)

    def say(self, text: str) -> Result:
        """Speaks with the voice of the agent's body, and waits for the result.

        Agents that hear the voice find the text in the `heard` of their next perception. `text` has
        at most 256 characters. A refusal is a result, as in `act`.
        """
        return self.act(str(self.body), protocol.SAY, text=text)

    # ---- lock-step ----

    def step(self, *acts: Act) -> Perception:
        """Performs the acts in the next frame and returns the perception after it, in lock-step.

        If a round has several frames, this is the perception at the end of the round. The field
        `results` of the perception contains the results of the acts.
        """
        self.ready(*acts)
        return self.observe()

    def ready(self, *acts: Act) -> None:
        """Sends the acts for the next frame and ends this agent's round, in lock-step."""
        with self._sending:
            with self._changed:
                lines = self._talk.ready(acts)
            self._send(lines)

    def observe(self, frame: int = 0) -> Perception:
        """Waits for the next perception that was not returned yet, in lock-step. It is the
        perception of the given frame or of a later frame.

        The world waits for this agent after the frame of the perception. The first perception is
        that of the frame in which the agent joined.
        """
        patience = self._timeout + self._talk.patience()
        while True:
            with self._sending:
                with self._changed:
                    line = self._talk.say_ready() if self._talk.must_say_ready() else None
                if line is not None:
                    self._send(line)
            with self._changed:
                self._wait(
                    lambda: self._talk.has_observation(frame) or self._talk.must_say_ready(),
                    patience,
                )
                if self._talk.has_observation(frame):
                    return self._talk.observation()


class Control(Client, Commands[Result, Report]):
    """A controller of a world. It perceives everything, and each command waits for its result."""

    def __enter__(self) -> Control:
        return self

    def look(self, sensor: str, item: Union[str, Item]) -> Image:
        """Returns the current picture of a camera of any body.

        Raises ReveError with the server's code if there is no picture.
        """
        body = item if isinstance(item, str) else item.name
        return self._ask(lambda number: protocol.look(number, sensor, body), Image)

    def foresee(self, frames: int, *changes: Mapping[str, object]) -> Perception:
        """Returns the perception of a copy of the world after `frames` more frames in which no
        agent acts. The copy first makes the `changes`.

        Raises ReveError with the server's code if it refuses a prediction of so many frames.
        """
        return self._answer(lambda: self._talk.fork(frames, changes), self._talk.foreseen)

    def begin_edits(self, edits: Sequence[Tuple[str, str, Argument]]) -> Callable[[], List[Result]]:
        """Sends edits for the next frame. Each edit is an item, a property and a value, as in
        `edit`.

        Returns when the server has received all edits. The returned function waits for the results.
        """
        with self._sending:
            with self._changed:
                questions = [self._talk.question(partial(_edit, edit)) for edit in edits]
            self._send(b"".join(line for _, line in questions))
        self.ping()
        return lambda: [self._result(number) for number, _ in questions]

    def _result(self, number: int) -> Result:
        return self._answer_to(number, lambda n: self._talk.answer(n, Result))

    def _report(self, t: str, **fields: object) -> Report:
        return self._answer(
            lambda: self._talk.question(lambda number: protocol.command(number, t, **fields)),
            self._talk.reported,
        )

    def _command(self, t: str, **fields: object) -> Result:
        return self._ask(lambda number: protocol.command(number, t, **fields), Result)


def _edit(edit: Tuple[str, str, Argument], number: int) -> Message:
    item, property, value = edit
    return protocol.command(number, "edit", item=item, property=property, value=value)
