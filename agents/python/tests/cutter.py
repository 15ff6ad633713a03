# SPDX-License-Identifier: Apache-2.0
"""A proxy that breaks connections to a server."""

from __future__ import annotations

import random
import socket
import threading
from typing import Optional

_CHUNK = 4096


class Cutter:
    """A proxy that ends each connection after some bytes from the server."""

    def __init__(self, server: int, seed: int, most_bytes: int) -> None:
        self.cuts = 0
        self._server = server
        self._random = random.Random(seed)
        self._most_bytes = most_bytes
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = self._listening.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self) -> Cutter:
        return self

    def __exit__(self, *_: object) -> None:
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listening.accept()
            except OSError:
                return  # closed
            way = socket.create_connection(("127.0.0.1", self._server))
            most = self._random.randrange(self._most_bytes // 4, self._most_bytes)
            for source, target, left in (client, way, None), (way, client, most):
                threading.Thread(
                    target=self._pass_on, args=(source, target, left), daemon=True
                ).start()

    def _pass_on(self, source: socket.socket, target: socket.socket, left: Optional[int]) -> None:
        try:
            while data := source.recv(_CHUNK):
                target.sendall(data[:left])
                if left is not None:
                    left -= len(data)
                    if left <= 0:
                        self.cuts += 1
                        break
        except OSError:
            pass  # the other direction ended it
        for end in (source, target):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # it has ended
        source.close()
