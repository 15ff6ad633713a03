# SPDX-License-Identifier: Apache-2.0
"""Encrypted connections: TLS over a socket."""

from __future__ import annotations

import errno
import socket
import ssl
import threading
from typing import Union

from .errors import Disconnected

Tls = Union[bool, str, ssl.SSLContext]
"""The trusted certificates: True for the authorities that this machine trusts, or a file of
certificates (PEM) that are trusted instead.
"""

_CHUNK = 64 * 1024


def secure(connection: socket.socket, host: str, tls: Tls) -> TlsSocket:
    """Makes the TLS handshake and checks that the server is `host`.

    Raises Disconnected with `tls-failed` if this fails.
    """
    try:
        return TlsSocket(connection, trusting(tls), host)
    except socket.timeout:
        raise
    except (ssl.SSLError, EOFError) as error:
        raise failed(error) from error


def trusting(tls: Tls) -> ssl.SSLContext:
    """Returns a TLS context that trusts the certificates of `tls`, which is not False."""
    if isinstance(tls, ssl.SSLContext):
        return tls
    if tls is True:
        return ssl.create_default_context()
    try:
        return ssl.create_default_context(cafile=tls or None)
    except FileNotFoundError:
        raise FileNotFoundError(
            errno.ENOENT, "there is no file of certificates to trust", tls
        ) from None
    except ssl.SSLError as error:
        raise Disconnected(
            "tls-failed", f"{tls} cannot be trusted: {error}", "expected certificates in PEM"
        ) from error


def failed(error: Exception) -> Disconnected:
    """Returns the exception for a failed handshake."""
    return Disconnected(
        "tls-failed",
        str(error),
        "does the server speak TLS, and is its certificate one that you trust?",
    )


class TlsSocket:
    """A socket with TLS. One thread may read while other threads write, which ssl.SSLSocket does
    not permit."""

    def __init__(self, connection: socket.socket, context: ssl.SSLContext, host: str) -> None:
        self._socket = connection
        self._incoming, self._outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        self._tls = context.wrap_bio(self._incoming, self._outgoing, server_hostname=host)
        self._lock = threading.Lock()
        while True:
            try:
                self._tls.do_handshake()
                break
            except ssl.SSLWantReadError:
                self._flush()
                if not self._fill():
                    raise EOFError(
                        "the server closed the connection before it was private"
                    ) from None
            except ssl.SSLError:
                self._flush()  # sends the TLS alert with the reason to the server
                raise
        self._flush()

    def sendall(self, data: bytes) -> None:
        with self._lock:
            self._tls.write(data)
            self._flush()

    def recv(self, size: int) -> bytes:
        while True:
            with self._lock:
                try:
                    return self._tls.read(size)
                except (ssl.SSLZeroReturnError, ssl.SSLEOFError):
                    return b""
                except ssl.SSLWantReadError:
                    self._flush()
            self._fill()

    def settimeout(self, seconds: Union[float, None]) -> None:
        self._socket.settimeout(seconds)

    def shutdown(self, how: int) -> None:
        self._socket.shutdown(how)

    def close(self) -> None:
        self._socket.close()

    def _flush(self) -> None:
        waiting = self._outgoing.read()
        if waiting:
            self._socket.sendall(waiting)

    def _fill(self) -> bool:
        data = self._socket.recv(_CHUNK)
        with self._lock:
            if data:
                self._incoming.write(data)
            else:
                self._incoming.write_eof()
        return bool(data)
