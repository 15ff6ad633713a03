"""A blocking client. One thread of its own reads, so pings are answered while the agent thinks."""

from __future__ import annotations

import itertools
import socket
import threading
from collections import deque
from typing import Callable, Deque, Dict, Iterator, List, Optional, Type, TypeVar, Union

from . import protocol
from .errors import Disconnected, ProtocolError, ReveError
from .protocol import (
    Argument,
    Bye,
    Error,
    Event,
    Item,
    Message,
    Perception,
    Ping,
    Pong,
    Result,
    ServerMessage,
    Welcome,
)

_EVENTS_KEPT = 1024

_T = TypeVar("_T")


def connect(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str,
    body: Optional[str] = None,
    timeout: float = 10.0,
) -> Agent:
    """Joins the world at that address as agent `name` and returns when it has a body there.

    `body` names an item that the world lends to agents; without it the world chooses one. `timeout` [s]
    bounds this and every later wait for an answer. Raises OSError where nobody listens, Disconnected with
    the server's code where the agent may not join.
    """
    connection = socket.create_connection((host, port), timeout)
    try:
        return Agent(connection, name, body, timeout)
    except BaseException:
        connection.close()
        raise


class Agent:
    """An agent in a world, from `connect`. Its methods may be called from any thread.

    Every call raises Disconnected once the connection has ended, and ReveError with code `no-answer` when
    the server is silent for longer than the timeout.
    """

    def __init__(
        self, connection: socket.socket, name: str, body: Optional[str], timeout: float
    ) -> None:
        self._socket = connection
        self._timeout = timeout
        self._ids = itertools.count(1)
        self._sending = threading.Lock()
        self._changed = threading.Condition()
        self._waiting: Dict[int, Optional[ServerMessage]] = {}
        self._subscription: Optional[int] = None
        self._latest: Optional[Perception] = None
        self._events: Deque[Event] = deque(maxlen=_EVENTS_KEPT)
        self._end: Optional[ReveError] = None

        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        lines = connection.makefile("rb")
        self._send(protocol.hello(name, body))
        self.welcome: Welcome = _await_welcome(lines.readline)
        connection.settimeout(None)
        self._reader = threading.Thread(
            target=self._read, args=(lines.readline,), name=f"reve agent {name}", daemon=True
        )
        self._reader.start()

    @property
    def name(self) -> str:
        return self.welcome.agent

    @property
    def body(self) -> str:
        """The name of the item that is this agent's body."""
        return self.welcome.body

    def perceive(self) -> Perception:
        """The items of the next frame."""
        return self._ask(protocol.perceive, Perception)

    def perceptions(self, every: int = 1) -> Iterator[Perception]:
        """A perception every that many frames, always the newest: a slow loop skips, it never lags.

        An agent has one such stream; starting another ends the first.
        """
        if every < 1:
            raise ValueError(f"every is {every}; expected a number of frames, 1 or more")
        number = next(self._ids)
        with self._changed:
            self._subscription, self._latest = number, None
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
            self._send_line(protocol.encode(protocol.bye()))
            self._reader.join(self._timeout)  # ends with the server's bye, or with the connection
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the connection is gone already, which is all we want
        self._reader.join()
        self._socket.close()

    def __enter__(self) -> Agent:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, question: Callable[[int], Message], answer_type: Type[_T]) -> _T:
        number = next(self._ids)
        message = question(number)
        with self._changed:
            self._waiting[number] = None
        try:
            self._send(message)
            with self._changed:
                self._wait(lambda: self._waiting[number] is not None, self._timeout)
                answer = self._waiting[number]
        finally:
            with self._changed:
                del self._waiting[number]
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
            self._subscription = self._latest = None
            if self._end is not None:
                return
        self._send(protocol.perceive(next(self._ids), 0))

    def _send(self, message: Message) -> None:
        line = protocol.encode(message)
        with self._changed:
            if self._end is not None:
                raise self._end
        try:
            self._send_line(line)
        except OSError as error:
            self._finish(Disconnected("lost", f"the connection broke: {error}"))
            with self._changed:
                raise self._end or error

    def _send_line(self, line: bytes) -> None:
        with self._sending:
            self._socket.sendall(line)

    def _read(self, readline: Callable[[], bytes]) -> None:
        end: ReveError = Disconnected("lost", "the server closed the connection without a reason")
        try:
            while True:
                line = readline()
                if not line:
                    break
                message = protocol.decode(line)
                if isinstance(message, Bye):
                    end = Disconnected(message.code, message.message, message.hint)
                    break
                self._take(message)
        except OSError as error:
            end = Disconnected("lost", f"the connection broke: {error}")
        except ReveError as error:
            end = error
        self._finish(end)

    def _take(self, message: ServerMessage) -> None:
        if isinstance(message, Ping):
            self._send_line(protocol.encode(protocol.pong()))
            return
        with self._changed:
            if isinstance(message, Event):
                self._events.append(message)
            elif isinstance(message, Perception) and message.id == self._subscription:
                self._latest = message
            elif isinstance(message, (Perception, Result, Pong, Error)):
                self._answer(message)
            self._changed.notify_all()

    def _answer(self, message: Union[Perception, Result, Pong, Error]) -> None:
        if message.id is not None and message.id in self._waiting:
            self._waiting[message.id] = message
        elif isinstance(message, Error):
            raise ReveError(message.code, message.message, message.hint)

    def _finish(self, end: ReveError) -> None:
        with self._changed:
            if self._end is None:
                self._end = end
            self._changed.notify_all()


def _await_welcome(readline: Callable[[], bytes]) -> Welcome:
    """Before the welcome the server may only ping, refuse the hello or end the connection."""
    while True:
        try:
            line = readline()
        except socket.timeout as error:
            raise ReveError(
                "no-answer", "the server did not welcome us in time", "is its world running?"
            ) from error
        if not line:
            raise Disconnected("lost", "the server closed the connection before its welcome")
        message = protocol.decode(line)
        if isinstance(message, Welcome):
            return message
        if isinstance(message, Bye):
            raise Disconnected(message.code, message.message, message.hint)
        if isinstance(message, Error):
            raise ReveError(message.code, message.message, message.hint)
        if not isinstance(message, Ping):
            raise ProtocolError(f"expected a welcome, got {message}")
