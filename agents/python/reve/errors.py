# SPDX-License-Identifier: Apache-2.0
"""What can go wrong between an agent and its world."""

from __future__ import annotations

from typing import Optional


class ReveError(Exception):
    """The server refused a message, or did not answer. `code` is for programs, the rest for people."""

    def __init__(self, code: str, message: str, hint: Optional[str] = None) -> None:
        super().__init__(f"{code}: {message}" + (f" ({hint})" if hint else ""))
        self.code = code
        self.message = message
        self.hint = hint


class Disconnected(ReveError):
    """The connection ended; `code` is the server's reason, or `lost` where it gave none."""


class ProtocolError(ReveError):
    """The other side sent something that is not protocol version 1."""

    def __init__(self, message: str) -> None:
        super().__init__("protocol", message)
