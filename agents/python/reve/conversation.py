# SPDX-License-Identifier: Apache-2.0
"""The protocol state of a client, without sockets and threads. Not thread-safe."""

from __future__ import annotations

import dataclasses
import itertools
import logging
import ssl
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Callable, Deque, Dict, List, Optional, Set, Tuple, Type, TypeVar, Union

from . import protocol
from .errors import Disconnected, ProtocolError, ReveError
from .protocol import (
    Act,
    Bye,
    Error,
    Event,
    Heard,
    Image,
    Message,
    Perception,
    Ping,
    Pong,
    Report,
    Result,
    ServerMessage,
    Update,
    Welcome,
)

RETRY_SECONDS = 0.2  # pause between two attempts to resume
_ATTEMPT_SECONDS = 5.0  # maximum wait for an answer to a resume, if there are several servers
CHUNK_BYTES = 1 << 16  # maximum size of one read

_EVENTS_KEPT = 1024
# Codes of a refused `resume` after which a client tries again during its time of grace.
_RETRIED = ("lost", "resumed-too-often", "moved", "world-starting")
_LOG = logging.getLogger("reve")

_T = TypeVar("_T")


class Way:
    """The search for the server of a cluster that has the world."""

    _MOST_MOVES = 4  # number of servers that may send a client to another one without a pause
    _MOST_ROUNDS = 10  # number of pauses, in which the servers learn where the world is

    def __init__(self, first: Tuple[str, int]) -> None:
        self.address = first
        self._first = first
        self._moves = 0
        self._rounds = 0

    def after(self, error: Exception) -> float:
        """Sets the next address after a failure, and returns the time to wait before [s]. Raises
        the failure if another attempt would fail, too."""
        moved = error.address if isinstance(error, Disconnected) else None
        if moved is not None and self._moves < self._MOST_MOVES:
            self._moves += 1
            self.address = moved
            return 0.0
        astray = moved is not None and self._rounds < self._MOST_ROUNDS
        starts = isinstance(error, Disconnected) and error.code == "world-starting"
        # Another server has sent the client to this one, which has ended a moment ago.
        ended = isinstance(error, OSError) or _is_closing(error)
        if not starts and not astray and not (ended and self._moves > 0):
            raise error
        self._rounds += astray
        self._moves = 0
        self.address = self._first
        return RETRY_SECONDS


def _is_closing(error: Exception) -> bool:
    return isinstance(error, Disconnected) and error.code == "closing"


def _is_out(error: Exception) -> bool:
    """Returns whether a server ends, or accepts connections and does not answer."""
    if isinstance(error, Disconnected) and error.code == "tls-failed":  # ended in the handshake
        return isinstance(error.__cause__, (EOFError, ssl.SSLEOFError))
    return _is_closing(error) or isinstance(error, ReveError) and error.code == "no-answer"


def welcome_in(message: Optional[ServerMessage]) -> Optional[Welcome]:
    """Returns the welcome, or None if the client must read further messages.

    Before the welcome, the server may only send pings, refuse the hello or end the connection. The
    argument is None at the end of the connection.
    """
    if message is None:
        raise Disconnected("lost", "the server closed the connection before its welcome")
    if isinstance(message, Welcome):
        return message
    if isinstance(message, Bye):
        raise Disconnected(message.code, message.message, message.hint, message.address)
    if isinstance(message, Error):
        raise ReveError(message.code, message.message, message.hint)
    if not isinstance(message, Ping):
        raise ProtocolError(f"expected a welcome, got {message}")
    return None


def result_in(message: Optional[ServerMessage]) -> Optional[Result]:
    """Returns the answer to a question that took the place of a welcome, or None if the client must
    read further messages."""
    if isinstance(message, Result):
        return message
    if welcome_in(message) is not None:
        raise ProtocolError("the server has opened a session instead of an answer")
    return None


class Conversation:
    """One session, over one or more connections.

    Methods return bytes to send; `take` receives messages.
    """

    def __init__(self, greeting: Message, welcome: Welcome) -> None:
        self.welcome = welcome
        self.end: Optional[ReveError] = None
        self.missed_events = 0
        self._encoding = str(greeting.get("encoding", protocol.JSON))
        self._token: Optional[str] = greeting.get("token")
        self._ids = itertools.count(1)
        self._waiting: Dict[int, Optional[ServerMessage]] = {}
        self._unanswered: Dict[int, bytes] = {}
        self._ahead: Set[int] = set()  # requests for the perception of a future frame
        # The stream of perceptions. The stream of an agent in lock-step has no id and exists from
        # the beginning.
        self._streaming = welcome.time is not None
        self._subscription: Optional[int] = None
        self._every = 0
        self._known: Optional[Perception] = None
        self._latest: Optional[Perception] = None
        self._doing: List[int] = []  # numbers of this agent's acts in the current round
        self._ready_frame = -1  # frame of the newest perception that `ready` answered
        self._observed_frame = -1
        self._events: Deque[Event] = deque(maxlen=_EVENTS_KEPT)
        self._heard: Deque[Heard] = deque(maxlen=_EVENTS_KEPT)
        self._frame_seen = welcome.frame - 1
        # All events up to the frame `_frame_seen` have arrived. `_heard_after` events of the next
        # frame have arrived.
        self._heard_after = 0
        self._known_already = 0
        self._known_servers: List[Tuple[str, int]] = []  # of a cluster, for `another_address`
        self.know_servers(welcome)

    # ---- requests ----

    def question(self, build: Callable[[int], Message]) -> Tuple[int, bytes]:
        """Creates a message that will be answered. Returns its number and its bytes. Until the
        answer arrives, it is sent again after each reconnection.
        """
        self.require_open()
        number = next(self._ids)
        line = self.encode(build(number))
        self._waiting[number] = None
        self._unanswered[number] = line
        return number, line

    def fork(self, frames: int, changes: Sequence[Mapping[str, object]] = ()) -> Tuple[int, bytes]:
        """Requests the perception of a copy of the world after `frames` more frames."""
        fields: dict[str, Any] = {"changes": list(changes)} if changes else {}
        number, line = self.question(
            lambda id: protocol.command(id, "fork", frames=frames, **fields)
        )
        self._ahead.add(number)
        return number, line

    def foreseen(self, number: int) -> Perception:
        """Returns the answer to `fork`, or raises the server's refusal."""
        answer: object = self.answer(number, object)
        if isinstance(answer, Perception):
            return answer
        if isinstance(answer, Result):
            reason = answer.reason or "the server does not look ahead"
            raise ReveError(answer.code or "refused", reason)
        raise ProtocolError(f"expected a perception, got {answer}")

    def reported(self, number: int) -> Report:
        """Returns the answer to a question about the world, or raises the server's refusal."""
        answer: object = self.answer(number, object)
        if isinstance(answer, Report):
            return answer
        if isinstance(answer, Result):
            raise ReveError(answer.code or "refused", answer.reason or "the server does not answer")
        raise ProtocolError(f"expected a report, got {answer}")

    def has_answer(self, number: int) -> bool:
        return self._waiting[number] is not None

    def answer(self, number: int, answer_type: Type[_T]) -> _T:
        """Returns the answer, or raises the server's refusal."""
        answer = self._waiting[number]
        if isinstance(answer, Error):
            raise ReveError(answer.code, answer.message, answer.hint)
        if isinstance(answer, Perception) and number not in self._ahead:
            answer = self._with_heard(answer)
        if not isinstance(answer, answer_type):
            raise ProtocolError(f"expected {answer_type.__name__} {number}, got {answer}")
        return answer

    def drop(self, number: int) -> None:
        """Removes a request, so that its answer is ignored."""
        self._waiting.pop(number, None)
        self._unanswered.pop(number, None)
        self._ahead.discard(number)

    def encode(self, message: Message) -> bytes:
        return protocol.encode(message, self._encoding)

    def require_open(self) -> None:
        if self.end is not None:
            raise self.end

    def finish(self, end: ReveError) -> None:
        """Ends the session; only the first reason is kept."""
        if self.end is None:
            self.end = end

    # ---- a stream of perceptions ----

    def subscribe(self, every: int) -> Tuple[int, bytes]:
        """Starts a stream, which replaces the previous one."""
        if every < 1:
            raise ValueError(f"every is {every}; expected a number of frames, 1 or more")
        if self.welcome.time is not None:
            raise ReveError(
                "lock-step", "an agent in lock-step perceives its rounds", "use observe or step"
            )
        self.require_open()
        number = next(self._ids)
        self._streaming, self._subscription, self._every = True, number, every
        self._latest = self._known = None
        return number, self.encode(protocol.perceive(number, every))

    def has_stream(self, number: int) -> bool:
        return self._streaming and self._subscription == number

    def has_news(self, number: int) -> bool:
        """Returns True if the stream has a new perception or has ended."""
        return not self.has_stream(number) or self._latest is not None

    def news(self, number: int) -> Optional[Perception]:
        """Returns the newest perception of a stream; None if it has ended."""
        if not self.has_stream(number):
            return None
        latest, self._latest = self._latest, None
        return None if latest is None else self._with_heard(latest)

    def _with_heard(self, perception: Perception) -> Perception:
        """Adds the texts that were heard up to the frame of the perception and not returned yet."""
        heard: List[Heard] = []
        while self._heard and self._heard[0].frame <= perception.frame:
            heard.append(self._heard.popleft())
        return dataclasses.replace(perception, heard=tuple(heard)) if heard else perception

    def unsubscribe(self, number: int) -> Optional[bytes]:
        if not self.has_stream(number):
            return None
        self._streaming, self._subscription = False, None
        self._latest = self._known = None
        return None if self.end is not None else self.encode(protocol.perceive(next(self._ids), 0))

    # ---- lock-step ----

    def ready(self, acts: Tuple[Act, ...]) -> bytes:
        """Returns the bytes that send the acts and end this agent's part of the round."""
        self._require_lock_step()
        self.require_open()
        for number in self._doing:
            self.drop(number)
        self._doing = []
        self._ready_frame = -1 if self._known is None else self._known.frame
        frame = None if self._known is None else self._known.frame
        if not acts:
            return self.encode(protocol.ready(frame))
        lines = [self._do(act) for act in acts[:-1]]
        return b"".join(lines) + self._do(acts[-1], lambda act: protocol.and_ready(act, frame))

    def _do(self, act: Act, say: Callable[[Message], Message] = lambda act: act) -> bytes:
        item = self.welcome.body if act.item is None else act.item
        number, line = self.question(
            lambda id: say(protocol.act(id, str(item), act.action, act.arguments))
        )
        self._doing.append(number)
        return line

    def has_observation(self, frame: int) -> bool:
        """Returns True if a perception of the given frame or a later one is complete and was not
        returned yet.

        A perception is complete when the results of the acts before it are known.
        """
        self._require_lock_step()
        return (
            self._known is not None
            and self._known.frame > max(self._observed_frame, frame - 1)
            and all(self.has_answer(number) for number in self._doing)
        )

    def observation(self) -> Perception:
        assert self._known is not None
        numbers, self._doing = self._doing, []
        self._observed_frame = self._known.frame
        try:
            results = tuple(self.answer(number, Result) for number in numbers)
        finally:
            for number in numbers:
                self.drop(number)
        return dataclasses.replace(self._with_heard(self._known), results=results)

    def must_say_ready(self) -> bool:
        """Returns True if the client must send a `ready` without acts.

        This is necessary if a round ended without this agent. The world waits for the agent in the
        next round, while the agent still waits for results of its acts.
        """
        return (
            bool(self._doing)
            and self._known is not None
            and self._known.frame > self._ready_frame
            and not all(self.has_answer(number) for number in self._doing)
        )

    def say_ready(self) -> bytes:
        assert self._known is not None
        self._ready_frame = self._known.frame
        return self.encode(protocol.ready(self._known.frame))

    def patience(self) -> float:
        """Returns the maximum time that the server waits for other agents in a round [s]."""
        time = self.welcome.time
        return 0.0 if time is None else time.deadline + time.every / self.welcome.rate

    def _require_lock_step(self) -> None:
        if self.welcome.time is None:
            raise ReveError(
                "not-lock-step",
                "this agent is not in lock-step",
                "connect with time=reve.LockStep()",
            )

    # ---- received messages ----

    def events(self) -> List[Event]:
        events = list(self._events)
        self._events.clear()
        return events

    def take(self, message: ServerMessage) -> Optional[bytes]:
        """Processes a received message. Returns the bytes to send at once, if any."""
        if isinstance(message, Ping):
            return self.encode(protocol.pong())
        if isinstance(message, Bye):
            raise Disconnected(message.code, message.message, message.hint, message.address)
        if isinstance(message, Event) and message.type == "missed":
            self._miss(message)
        elif isinstance(message, Event):
            self._hear(message)
        elif isinstance(message, (Perception, Update)) and self._is_of_stream(message):
            self._show(message)
        elif isinstance(message, (Perception, Image, Report, Result, Pong, Error)):
            self._answer(message)
        return None

    def _hear(self, event: Event) -> None:
        if self._known_already > 0:  # the server sent this event again after the reconnection
            self._known_already -= 1
            return
        self._events.append(event)
        if event.type == protocol.HEARD:
            self._heard.append(protocol.heard(event))
        self._has_seen(event.frame - 1)
        if event.frame > self._frame_seen:
            self._heard_after += 1

    def _miss(self, gap: Event) -> None:
        """Stores the event `gap`, which represents events that were not sent, and counts these
        events."""
        if self.missed_events == 0:
            _LOG.warning(
                "%s misses events from frame %d to %d, as it reads too slowly or others cause too "
                "many at once; from now on only its "
                "missed_events counts them",
                self.welcome.agent,
                gap.fields["first"],
                gap.frame,
            )
        count = gap.fields.get("events", 1)
        self.missed_events += int(count) if isinstance(count, (int, float)) else 1
        self._events.append(gap)
        self._has_seen(gap.frame)
        self._known_already = min(self._known_already, self._heard_after)

    def _has_seen(self, frame: int) -> None:
        """Records that all events up to the given frame have arrived."""
        if frame > self._frame_seen:
            self._frame_seen = frame
            self._heard_after = 0

    def _is_of_stream(self, message: Union[Perception, Update]) -> bool:
        return self._streaming and message.id == self._subscription

    def _show(self, message: Union[Perception, Update]) -> None:
        if isinstance(message, Perception):
            self._known = message
        elif self._known is not None:
            self._known = self._known.updated(message)
        self._latest = self._known
        self._has_seen(message.frame)

    def _answer(self, message: Union[Perception, Image, Report, Result, Pong, Error]) -> None:
        if isinstance(message, Perception) and message.id not in self._ahead:
            self._has_seen(message.frame)
        if message.id is not None and message.id in self._waiting:
            self._waiting[message.id] = message
            self._unanswered.pop(message.id, None)
        elif isinstance(message, Error):
            raise ReveError(message.code, message.message, message.hint)

    # ---- reconnection ----

    def greeting(self) -> Optional[Message]:
        """Returns the hello that resumes the session on another connection; None if that is
        impossible."""
        if self.welcome.session is None or self.end is not None:
            return None
        return protocol.hello(
            self.welcome.agent,
            role=self.welcome.role,
            encoding=self._encoding,
            resume=(self.welcome.session.token, max(0, self._frame_seen)),
            token=self._token,
            world=self.welcome.world,
        )

    def next_address(self, current: Tuple[str, int], end: Disconnected) -> Tuple[str, int]:
        """Returns the address at which the session continues after its world has moved from the
        current server to another one of a cluster. Raises `end` if the session does not continue.
        """
        if end.code != "moved" or end.address is None or self.welcome.session is None:
            raise end
        self._note(current)
        self._note(end.address)
        return end.address

    def know_servers(self, welcome: Welcome) -> None:
        """Notes the servers at which the session can be resumed."""
        for server in () if welcome.session is None else welcome.session.servers:
            self._note(server)

    def attempt_seconds(self, timeout: float, left: float) -> float:
        """Returns the time for one attempt to resume the session [s]."""
        most = min(timeout, left)
        return min(most, _ATTEMPT_SECONDS) if len(self._known_servers) > 1 else most

    def _note(self, server: Tuple[str, int]) -> None:
        if server not in self._known_servers:
            self._known_servers.append(server)

    def another_address(self, tried: Tuple[str, int], error: Exception) -> Tuple[str, int]:
        """Returns the address for the next attempt to resume the session: where the server sends
        the client, or the next known server if the tried one does not answer or ends."""
        self._note(tried)
        if isinstance(error, Disconnected) and error.address is not None:
            self._note(error.address)
            return error.address
        if not isinstance(error, OSError) and not _is_out(error):
            return tried
        place = self._known_servers.index(tried) + 1
        return self._known_servers[place % len(self._known_servers)]

    def may_retry(self, error: Exception) -> bool:
        """Returns False if a resume failed for a permanent reason. The end or the silence of a
        server is permanent if the client knows no other one."""
        if _is_out(error):
            return len(self._known_servers) > 1
        return not isinstance(error, ReveError) or error.code in _RETRIED

    def gone_on(self) -> bytes:
        """Returns the bytes to send over a new connection after its welcome.

        These are the unanswered messages, or the message bye if the client has left in the
        meantime.
        """
        if self.end is not None:
            return self.encode(protocol.bye())
        self._known_already = self._heard_after
        lines = b"".join(self._unanswered.values())
        if self._subscription is not None:
            lines += self.encode(protocol.perceive(self._subscription, self._every))
        return lines
