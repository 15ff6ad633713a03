# SPDX-License-Identifier: Apache-2.0
"""Errors between an agent and its world."""

from __future__ import annotations

from typing import Optional, Tuple


class ReveError(Exception):
    """A refused message, or a missing answer. The `code` is for programs, and the message is for
    people."""

    def __init__(self, code: str, message: str, hint: Optional[str] = None) -> None:
        super().__init__(f"{code}: {message}" + (f" ({hint})" if hint else ""))
        self.code = code
        self.message = message
        self.hint = hint


class Disconnected(ReveError):
    """The connection has ended. `code` is the server's reason, or `lost` if there was none.

    `address` is the host and port of the server that has the world, if this server named another
    server.
    """

    def __init__(
        self,
        code: str,
        message: str,
        hint: Optional[str] = None,
        address: Optional[Tuple[str, int]] = None,
    ) -> None:
        super().__init__(code, message, hint)
        self.address = address


class ProtocolError(ReveError):
    """The other side sent bytes that are not a message of protocol version 1."""

    def __init__(self, message: str) -> None:
        super().__init__("protocol", message)


def unreadable(error: Exception) -> ProtocolError:
    """Returns the exception for a message whose fields have wrong types."""
    return ProtocolError(f"the server sent a message that cannot be read ({error!r})")


# The functions below return the errors of connections that the blocking and the asyncio client
# raise.


def not_welcomed() -> ReveError:
    return ReveError("no-answer", "the server did not welcome us in time", "is its world running?")


def not_answered(seconds: float) -> ReveError:
    return ReveError("no-answer", f"the server was silent for {seconds} s", "is its world running?")


def broken(error: OSError) -> Disconnected:
    return Disconnected("lost", f"the connection broke: {error}")


def closed_by_server() -> Disconnected:
    return Disconnected("lost", "the server closed the connection without a reason")


def left() -> Disconnected:
    return Disconnected("closed", "we have left")
