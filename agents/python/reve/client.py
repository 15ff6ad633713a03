# SPDX-License-Identifier: Apache-2.0
"""A blocking client. One thread of its own reads, so pings are answered while the agent thinks."""

from __future__ import annotations

import errno
import socket
import threading
import time as clock
from functools import partial
from typing import (
    BinaryIO,
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
from .conversation import RETRIED, Conversation
from .errors import Disconnected, ProtocolError, ReveError
from .protocol import (
    Act,
    Argument,
    Bye,
    Error,
    Event,
    Image,
    Item,
    LockStep,
    Message,
    Perception,
    Ping,
    Pong,
    Result,
    ServerMessage,
    Welcome,
)
from .tls import Tls, TlsSocket, secure

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
    time: Optional[LockStep] = None,
    grace: float = 0.0,
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Agent:
    """Joins the world at that address as agent `name` and returns when it has a body there.

    `world` names one of the server's worlds; needed only where it has several.
    `body` names an item that the world lends to agents; without it the world chooses one.
    As `role` "observer" one perceives everything and does nothing.
    `encoding` "msgpack" is faster and needs the package msgpack.
    With a `time` the world waits for the agent, see `Agent.step`; else it goes on at its own pace.
    `grace` [s] is how long the body may wait for us when the connection breaks; we reconnect by
    ourselves, and whoever waits for an answer notices nothing.
    `token` is what a server that asks for one was told to expect.
    `tls` makes the connection private: True trusts whom this machine trusts, the name of a file
    only the certificates in it.
    `timeout` [s] bounds this and every later wait for an answer.

    Raises OSError where nobody listens, Disconnected with the server's code where the agent may not
    join.
    """
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
    """Joins a world to run it, without a body. As for `connect`."""
    greeting = protocol.hello(name, role=protocol.CONTROL, token=token, world=world)
    return Control((host, port), greeting, timeout, tls)


class Client:
    """What agents and controls have in common: a connection, and perceptions. For use by any
    thread.

    Every call raises Disconnected once the connection has ended, and ReveError with code
    `no-answer` when the server is silent for longer than the timeout.
    """

    def __init__(
        self, address: Tuple[str, int], greeting: Message, timeout: float, tls: Tls = False
    ) -> None:
        self._address = address
        self._timeout = timeout
        self._tls = tls
        self._sending = threading.Lock()  # taken before the other
        self._changed = threading.Condition()
        self._socket, self._stream, welcome = self._open(greeting)
        self._talk = Conversation(greeting, welcome)
        self._reader = threading.Thread(
            target=self._read, name=f"reve agent {welcome.agent}", daemon=True
        )
        self._reader.start()

    def _dial(self) -> socket.socket:
        try:
            return socket.create_connection(self._address, self._timeout)
        except OSError as error:
            host, port = self._address
            raise type(error)(
                error.errno or errno.ETIMEDOUT,
                f"{host}:{port}: {error.strerror or error}; does a server run there?",
            ) from error

    def _open(self, greeting: Message) -> Tuple[Union[socket.socket, TlsSocket], BinaryIO, Welcome]:
        plain = self._dial()
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
    def welcome(self) -> Welcome:
        """What the server said when we joined."""
        return self._talk.welcome

    @property
    def name(self) -> str:
        return self.welcome.agent

    def perceive(self, relations: bool = False) -> Perception:
        """The items of the next frame.

        With `relations`, the symbols of bodies with a shape hold `near`, `on`, `inside` and
        `touching`, too.
        """
        return self._ask(lambda id: protocol.perceive(id, relations=relations), Perception)

    def perceptions(self, every: int = 1) -> Iterator[Perception]:
        """A perception every that many frames, always the newest: a slow loop skips, it never lags.

        There is one such stream; starting another ends the first.
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
        """Returns when the server has answered."""
        self._ask(protocol.ping, Pong)

    def events(self) -> List[Event]:
        """What happened since the last call, oldest first; the last 1,024 events are kept.

        An event `missed` stands for those that the server did not send, as we read too slowly or
        others caused too many at once.
        """
        with self._changed:
            return self._talk.events()

    @property
    def missed_events(self) -> int:
        """How many events the server did not send, see `missed` above. At least: of what
        happened while a connection was broken it may not know how many, and counts one.
        """
        return self._talk.missed_events

    def close(self) -> None:
        """Leaves the world. Calling it again does nothing."""
        self._finish(Disconnected("closed", "we have left"))
        try:
            with self._sending:
                self._socket.sendall(self._talk.encode(protocol.bye()))
            self._reader.join(self._timeout)  # ends with the server's bye, or with the connection
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the connection is gone already, which is all we want
        self._reader.join()
        self._stream.close()
        self._socket.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- asking ----

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
        """With `_changed` held: until ready, or the end of the connection or of patience [s]."""
        self._changed.wait_for(lambda: self._talk.end is not None or ready(), patience)
        if not ready():
            raise self._talk.end or ReveError(
                "no-answer", f"the server was silent for {patience} s", "is its world running?"
            )

    def _send(self, lines: bytes) -> None:
        """With `_sending` held. Over a broken connection nothing: what matters is said again over
        the next.
        """
        try:
            self._socket.sendall(lines)
        except OSError as error:
            if self.welcome.session is None:
                self._finish(Disconnected("lost", f"the connection broke: {error}"))
                self._talk.require_open()

    def _finish(self, end: ReveError) -> None:
        with self._changed:
            self._talk.finish(end)
            self._changed.notify_all()

    # ---- the reader's thread ----

    def _read(self) -> None:
        end: ReveError = Disconnected("lost", "the server closed the connection without a reason")
        while True:
            try:
                message = protocol.read(self._stream)
                if message is not None:
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

    def _take(self, message: ServerMessage) -> None:
        with self._changed:
            reply = self._talk.take(message)
            self._changed.notify_all()
        if reply is not None:
            with self._sending:
                self._send(reply)

    def _resume(self) -> bool:
        """Goes on over another connection, until the time of grace is over. True if that worked."""
        ticket = self.welcome.session
        if ticket is None:
            return False
        self._stream.close()
        self._socket.close()
        deadline = clock.monotonic() + ticket.grace_seconds
        while clock.monotonic() < deadline:
            with self._changed:
                greeting = self._talk.greeting()
            if greeting is None:
                return False
            try:
                connection, stream, _ = self._open(greeting)
            except (ReveError, OSError) as error:
                if isinstance(error, ReveError) and error.code not in RETRIED:
                    self._finish(error)
                    return False
                with self._changed:
                    self._changed.wait_for(lambda: self._talk.end is not None, _RETRY_SECONDS)
                continue
            with self._sending:
                self._socket, self._stream = connection, stream
                with self._changed:
                    lines = self._talk.gone_on()
                self._send(lines)
            return True
        return False


class Agent(Client):
    """An agent in a world, from `connect`."""

    def __enter__(self) -> Agent:
        return self

    @property
    def body(self) -> Optional[str]:
        """The name of the item that is this agent's body; only the role "agent" has one."""
        return self.welcome.body

    def look(self, sensor: str) -> Image:
        """What one of our body's cameras sees now; ReveError with the server's code if there is no
        picture.
        """
        return self._ask(lambda number: protocol.look(number, sensor), Image)

    def act(self, item: Union[str, Item], action: str, /, **arguments: Argument) -> Result:
        """Asks the item to do one of its actions and waits for the outcome.

        A refusal is a result (`accepted` is False, with `code` and `reason`), not an exception.
        """
        target = item if isinstance(item, str) else item.name
        return self._ask(lambda number: protocol.act(number, target, action, arguments), Result)

    # ---- lock-step ----

    def step(self, *acts: Act) -> Perception:
        """In lock-step: does these things in the next frame and returns what is perceived then, or
        at the end of a round of several frames. The perception has the `results`.
        """
        self.ready(*acts)
        return self.observe()

    def ready(self, *acts: Act) -> None:
        """In lock-step: does these things in the next frame, for which the world need not wait any
        longer.
        """
        with self._sending:
            with self._changed:
                lines = self._talk.ready(acts)
            self._send(lines)

    def observe(self, frame: int = 0) -> Perception:
        """In lock-step: waits for the perception of that frame or a later one that was not observed
        yet, after which the world waits for us. The first is that of the frame that we joined in.
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


class Control(Client, Commands[Result]):
    """Runs a world, from `control`: perceives everything, and each command waits for its result."""

    def __enter__(self) -> Control:
        return self

    def foresee(self, frames: int) -> Perception:
        """What would be perceived that many frames from now, if nobody did anything.

        ReveError with the server's code if it refuses to look so far ahead.
        """
        return self._answer(lambda: self._talk.fork(frames), self._talk.foreseen)

    def begin_edits(self, edits: Sequence[Tuple[str, str, Argument]]) -> Callable[[], List[Result]]:
        """As `edit` for each item, property and value. Returns when the server has them all, which
        it does in the next frame; what is returned waits for the results.
        """
        with self._sending:
            with self._changed:
                questions = [self._talk.question(partial(_edit, edit)) for edit in edits]
            self._send(b"".join(line for _, line in questions))
        self.ping()
        return lambda: [self._result(number) for number, _ in questions]

    def _result(self, number: int) -> Result:
        return self._answer_to(number, lambda n: self._talk.answer(n, Result))

    def _command(self, t: str, **fields: object) -> Result:
        return self._ask(lambda number: protocol.command(number, t, **fields), Result)


def _edit(edit: Tuple[str, str, Argument], number: int) -> Message:
    item, property, value = edit
    return protocol.command(number, "edit", item=item, property=property, value=value)


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
