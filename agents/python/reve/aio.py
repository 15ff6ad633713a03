# SPDX-License-Identifier: Apache-2.0
"""The client for asyncio. Its coroutines `connect`, `control` and `cluster` correspond to those
functions of `reve`.

>>> import reve.aio
>>> async with await reve.aio.connect("127.0.0.1", 7777, name="ada") as agent:
...     print([item.name for item in (await agent.perceive()).items])
"""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Mapping
from typing import AsyncIterator, Awaitable, Callable, List, Optional, Tuple, Type, TypeVar, Union

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
from .tls import Tls, failed, trusting

_T = TypeVar("_T")
_Address = Tuple[str, int]


class _Wire:
    """One connection: sends messages, and yields received ones."""

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, encoding: str
    ) -> None:
        self.writer = writer
        self._reader = reader
        self._incoming = Incoming(encoding)

    async def next(self) -> Optional[ServerMessage]:
        """Returns the next message, or None at the end of the connection."""
        message = self._incoming.next()
        while message is None:
            data = await self._reader.read(CHUNK_BYTES)
            if not data:
                return None
            self._incoming.feed(data)
            message = self._incoming.next()
        return message

    async def await_welcome(self) -> Welcome:
        while True:
            welcome = welcome_in(await self.next())
            if welcome is not None:
                self._incoming.limit = protocol.MOST_BYTES
                return welcome

    async def await_result(self) -> Result:
        """Waits for the answer to a question that takes the place of a welcome."""
        self._incoming.limit = protocol.MOST_BYTES
        while True:
            result = result_in(await self.next())
            if result is not None:
                return result


async def _follow(
    address: _Address,
    greeting: Message,
    tls: Tls,
    timeout: float,
    first: Callable[[_Wire], Awaitable[_T]],
) -> Tuple[_Address, _Wire, _T]:
    """Opens a connection to the server that has the world. Returns its address, the connection and
    the first answer."""
    loop = asyncio.get_running_loop()
    deadline = loop.time() + timeout
    way = Way(address)
    while True:
        try:
            patience = deadline - loop.time()
            return (way.address, *await _open(way.address, greeting, tls, patience, first))
        except (Disconnected, OSError) as error:
            pause = way.after(error)
            if loop.time() + pause > deadline:
                raise
            await asyncio.sleep(pause)


async def _open(
    address: _Address,
    greeting: Message,
    tls: Tls,
    patience: float,
    first: Callable[[_Wire], Awaitable[_T]],
) -> Tuple[_Wire, _T]:
    """Connects, sends the greeting and waits for its answer, at most for `patience` [s]."""
    try:
        return await asyncio.wait_for(_greet(address, greeting, tls, first), patience)
    except asyncio.TimeoutError as error:
        raise not_welcomed() from error


async def _greet(
    address: _Address, greeting: Message, tls: Tls, first: Callable[[_Wire], Awaitable[_T]]
) -> Tuple[_Wire, _T]:
    context = trusting(tls) if tls else None
    try:
        reader, writer = await asyncio.open_connection(*address, ssl=context)
    except ssl.SSLError as error:
        raise failed(error) from error
    wire = _Wire(reader, writer, str(greeting.get("encoding", protocol.JSON)))
    try:
        writer.write(protocol.encode(greeting))
        return wire, await first(wire)
    except BaseException:
        writer.close()
        raise


async def connect(
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
    """Joins a world as `reve.connect` does, as a coroutine."""
    if role == protocol.CONTROL:
        raise ValueError('connect() joins agents and observers; use control() for role "control"')
    greeting = protocol.hello(
        name, body, role, encoding, grace, token=token, time=time, world=world
    )
    agent = Agent((host, port), greeting, timeout, tls)
    await agent._begin()
    return agent


async def control(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str = "control",
    world: Optional[str] = None,
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Control:
    """Joins a world as `reve.control` does, as a coroutine."""
    greeting = protocol.hello(name, role=protocol.CONTROL, token=token, world=world)
    boss = Control((host, port), greeting, timeout, tls)
    await boss._begin()
    return boss


async def cluster(
    host: str = "127.0.0.1",
    port: int = 7777,
    *,
    name: str = "control",
    token: Optional[str] = None,
    tls: Tls = False,
    timeout: float = 10.0,
) -> Result:
    """Asks a server for the nodes and worlds of its cluster as `reve.cluster` does, as a
    coroutine."""
    greeting = protocol.ask("cluster", name, token)
    _, wire, result = await _follow((host, port), greeting, tls, timeout, _Wire.await_result)
    wire.writer.close()
    return result


class Client:
    """The common part of agents and controls. It corresponds to `reve.Client`. Use it only from the
    tasks of one event loop."""

    _talk: Conversation
    _reader: asyncio.Task[None]

    def __init__(
        self, address: _Address, greeting: Message, timeout: float, tls: Tls = False
    ) -> None:
        self._address = address
        self._greeting = greeting
        self._timeout = timeout
        self._tls = tls
        self._waiters: List[asyncio.Future[None]] = []

    async def _begin(self) -> None:
        self._address, self._wire, welcome = await _follow(
            self._address, self._greeting, self._tls, self._timeout, _Wire.await_welcome
        )
        self._talk = Conversation(self._greeting, welcome)
        self._reader = asyncio.create_task(self._read())

    @property
    def welcome(self) -> Welcome:
        """The server's first answer, which describes the session."""
        return self._talk.welcome

    @property
    def name(self) -> str:
        return self.welcome.agent

    async def perceive(self, relations: bool = False) -> Perception:
        """Returns the items of the next frame."""
        return await self._ask(lambda id: protocol.perceive(id, relations=relations), Perception)

    async def perceptions(self, every: int = 1) -> AsyncIterator[Perception]:
        """Yields a perception every `every` frames, always the newest. A new stream ends the
        previous one."""
        number, line = self._talk.subscribe(every)
        self._send(line)
        patience = self._timeout + every / self.welcome.rate
        try:
            while True:
                await self._wait(lambda: self._talk.has_news(number), patience)
                perception = self._talk.news(number)
                if perception is None:
                    return
                yield perception
        finally:
            farewell = self._talk.unsubscribe(number)
            if farewell is not None:
                self._send(farewell)

    async def ping(self) -> None:
        """Sends a ping and returns when the server has answered."""
        await self._ask(protocol.ping, Pong)

    def events(self) -> List[Event]:
        """Returns the events since the last call, oldest first; at most the last 1,024 are kept.

        An event `missed` replaces events that the server did not send, because this client reads
        too slowly or other clients caused too many events at once.
        """
        return self._talk.events()

    @property
    def missed_events(self) -> int:
        """The minimum number of events that the server did not send, see `missed` in `events`.

        The server may not know the number while the connection was broken. It then counts one
        event.
        """
        return self._talk.missed_events

    async def close(self) -> None:
        """Leaves the world. Another call has no effect."""
        self._finish(left())
        self._send(self._talk.encode(protocol.bye()))
        await asyncio.wait([self._reader], timeout=self._timeout)
        self._reader.cancel()
        self._wire.writer.close()

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    # ---- requests ----

    async def _ask(self, build: Callable[[int], Message], answer_type: Type[_T]) -> _T:
        return await self._answer(
            self._talk.question(build), lambda number: self._talk.answer(number, answer_type)
        )

    async def _answer(self, question: Tuple[int, bytes], answer: Callable[[int], _T]) -> _T:
        number, line = question
        self._send(line)
        try:
            await self._wait(lambda: self._talk.has_answer(number), self._timeout)
            return answer(number)
        finally:
            self._talk.drop(number)

    async def _wait(self, ready: Callable[[], bool], patience: float) -> None:
        """Waits until `ready` is true, the connection ends, or `patience` [s] has passed."""
        loop = asyncio.get_running_loop()
        deadline = loop.time() + patience
        while not ready():
            if self._talk.end is not None:
                raise self._talk.end
            change = loop.create_future()
            self._waiters.append(change)
            await asyncio.wait([change], timeout=deadline - loop.time())
            if not change.done():
                self._waiters.remove(change)
                raise not_answered(patience)

    def _send(self, lines: bytes) -> None:
        if not self._wire.writer.is_closing():
            self._wire.writer.write(lines)

    def _finish(self, end: ReveError) -> None:
        self._talk.finish(end)
        self._changed()

    def _changed(self) -> None:
        waiters, self._waiters = self._waiters, []
        for waiter in waiters:
            if not waiter.done():
                waiter.set_result(None)

    # ---- the reader's task ----

    async def _read(self) -> None:
        try:
            await self._read_messages()
        except ReveError as error:
            self._finish(error)
        except Exception as error:  # a message whose fields have wrong types
            self._finish(unreadable(error))

    async def _read_messages(self) -> None:
        end: ReveError = closed_by_server()
        while True:
            try:
                message = await self._wire.next()
                if message is not None:
                    reply = self._talk.take(message)
                    if reply is not None:
                        self._send(reply)
                    self._changed()
                    continue
            except OSError as error:
                end = broken(error)
            except Disconnected as bye:
                self._address = self._talk.next_address(self._address, bye)
                end = bye
            if not await self._resume():
                raise end

    async def _resume(self) -> bool:
        """Reconnects until the time of grace is over. Returns True if the session continues."""
        ticket = self.welcome.session
        self._wire.writer.close()
        if ticket is None:
            return False
        loop = asyncio.get_running_loop()
        deadline = loop.time() + ticket.grace_seconds
        while loop.time() < deadline:
            greeting = self._talk.greeting()
            if greeting is None:
                return False
            try:
                patience = self._talk.attempt_seconds(self._timeout, deadline - loop.time())
                self._wire, welcome = await _open(
                    self._address, greeting, self._tls, patience, _Wire.await_welcome
                )
            except (ReveError, OSError) as error:
                if isinstance(error, ReveError) and not self._talk.may_retry(error):
                    self._finish(error)
                    return False
                self._address = self._talk.another_address(self._address, error)
                await asyncio.sleep(RETRY_SECONDS)
                continue
            self._talk.know_servers(welcome)
            self._send(self._talk.gone_on())
            return True
        return False


class Agent(Client):
    """An agent in a world, created by `connect`. It corresponds to `reve.Agent`."""

    async def __aenter__(self) -> Agent:
        return self

    @property
    def body(self) -> Optional[str]:
        """The name of the item that is this agent's body; only the role "agent" has one."""
        return self.welcome.body

    async def act(self, item: Union[str, Item], action: str, /, **arguments: Argument) -> Result:
        """Requests an action of the item and waits for its result. A refusal is a result, not an
        exception."""
        target = item if isinstance(item, str) else item.name
        return await self._ask(lambda id: protocol.act(id, target, action, arguments), Result)

    async def say(self, text: str) -> Result:
        """Speaks with the voice of the agent's body, as `reve.Agent.say`."""
        return await self.act(str(self.body), protocol.SAY, text=text)

    async def look(self, sensor: str) -> Image:
        """Returns the current picture of a camera of the agent's body.

        Raises ReveError with the server's code if there is no picture.
        """
        return await self._ask(lambda id: protocol.look(id, sensor), Image)

    async def step(self, *acts: Act) -> Perception:
        """Performs the acts in the next frame and returns the perception after it, in lock-step."""
        self.ready(*acts)
        return await self.observe()

    def ready(self, *acts: Act) -> None:
        """Sends the acts for the next frame and ends this agent's round, in lock-step."""
        self._send(self._talk.ready(acts))

    async def observe(self, frame: int = 0) -> Perception:
        """Waits for the next perception that was not returned yet, in lock-step. It is the
        perception of the given frame or of a later frame."""
        patience = self._timeout + self._talk.patience()
        while not self._talk.has_observation(frame):
            if self._talk.must_say_ready():
                self._send(self._talk.say_ready())
            await self._wait(
                lambda: self._talk.has_observation(frame) or self._talk.must_say_ready(), patience
            )
        return self._talk.observation()


class Control(Client, Commands[Awaitable[Result], Awaitable[Report]]):
    """A controller of a world, created by `control`. It corresponds to `reve.Control`."""

    async def __aenter__(self) -> Control:
        return self

    async def look(self, sensor: str, item: Union[str, Item]) -> Image:
        """Returns the current picture of a camera of any body, as `reve.Control.look`."""
        body = item if isinstance(item, str) else item.name
        return await self._ask(lambda id: protocol.look(id, sensor, body), Image)

    async def foresee(self, frames: int, *changes: Mapping[str, object]) -> Perception:
        """Returns the perception of a copy of the world after `frames` more frames in which no
        agent acts."""
        return await self._answer(self._talk.fork(frames, changes), self._talk.foreseen)

    def _report(self, t: str, **fields: object) -> Awaitable[Report]:
        return self._answer(
            self._talk.question(lambda id: protocol.command(id, t, **fields)), self._talk.reported
        )

    def _command(self, t: str, **fields: object) -> Awaitable[Result]:
        return self._ask(lambda id: protocol.command(id, t, **fields), Result)
