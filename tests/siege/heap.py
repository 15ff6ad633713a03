#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fills the queues of a running server with many agents, and measures its Java heap.

    tests/siege/heap.py [--agents 1000] [--heap 1g] [--seconds 30] [--reve ./reve]

A server with the world tests/siege/square.yaml starts with the given heap. The agents join, request
each frame with relations, shout texts of 1,000 characters that all agents hear, and read nothing,
so that each queue fills up to its limit. The server disconnects agents that read nothing; they
join again, and the server admits 100 agents a second. Once a
second a line tells the connections, and the size of the objects in the heap, including those that
the next garbage collection removes. Exits with 1 if this size has exceeded 70 % of the heap, or if
the server has ended.
"""

import argparse
import collections
import json
import os
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
HOST = "127.0.0.1"
MOST = 0.7
MIB = 1 << 20
SHOUTS_PER_SECOND = 2


class Agent:
    """An agent that sends, and reads nothing after it has joined. Its receive buffer is small."""

    def __init__(self, port, number):
        self.port = port
        self.name = f"crowd-{number}"
        self.joined = 0
        self.next_id = 0
        self.join()

    def join(self):
        self.joined += 1
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.settimeout(60)
        self.socket.connect((HOST, self.port))
        self.send({"t": "hello", "protocol": 1, "name": f"{self.name}-{self.joined}"})
        self.socket.recv(1)  # the beginning of the welcome
        self.send({"t": "perceive", "id": 1, "every": 1, "relations": True})
        self.socket.setblocking(False)

    def send(self, *messages):
        self.socket.sendall(b"".join(json.dumps(m).encode() + b"\n" for m in messages))

    def shout(self):
        self.next_id += 1
        act = {"item": "crier", "action": "shout", "arguments": {"text": "x" * 1000}}
        try:
            self.send({"t": "act", "id": self.next_id, **act})
        except BlockingIOError:
            pass  # the server reads nothing from this agent at present
        except OSError:
            self.socket.close()
            self.join()


def metrics(url):
    with urllib.request.urlopen(f"{url}/metrics", timeout=30) as answer:
        text = answer.read().decode()
    return {
        name: float(re.search(rf"^{name} (\S+)$", text, re.MULTILINE).group(1))
        for name in ("reve_connections", "reve_heap_used_bytes", "reve_heap_max_bytes")
    }


def crowd(port, count, stop):
    agents = [Agent(port, number) for number in range(count)]
    while not stop.is_set():
        begin = time.monotonic()
        for agent in agents:
            agent.shout()
        stop.wait(max(0, 1 / SHOUTS_PER_SECOND - (time.monotonic() - begin)))
    for agent in agents:
        agent.socket.close()


def measure(options):
    world = (ROOT / "tests/siege/square.yaml").read_text()
    world = world.replace("\nagents:\n", f"\nagents:\n  most: {2 * options.agents}\n")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "square.yaml")
        file.write_text(world)
        server = subprocess.Popen(
            [options.reve, "serve", file, "--port", "0", "--web", "0", "--json"],
            env={**os.environ, "REVE_HEAP": options.heap},
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            return watch(server, options)
        finally:
            server.terminate()
            server.wait()


def watch(server, options):
    ready = json.loads(server.stdout.readline())
    threading.Thread(target=collections.deque, args=(server.stdout, 0), daemon=True).start()
    url = ready["web"].rstrip("/")
    stop = threading.Event()
    thread = threading.Thread(
        target=crowd, args=(int(ready["agentPort"]), options.agents, stop), daemon=True
    )
    thread.start()
    peak = 0
    end = time.monotonic() + options.seconds
    while time.monotonic() < end and server.poll() is None:
        time.sleep(1)
        now = metrics(url)
        share = now["reve_heap_used_bytes"] / now["reve_heap_max_bytes"]
        peak = max(peak, share)
        print(
            f"{now['reve_connections']:.0f} connections, "
            f"{now['reve_heap_used_bytes'] / MIB:.0f} of "
            f"{now['reve_heap_max_bytes'] / MIB:.0f} MiB, {share:.0%}",
            flush=True,
        )
    stop.set()
    thread.join()
    print(f"peak {peak:.0%} of the heap, at most {MOST:.0%} expected")
    return peak <= MOST and server.poll() is None


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--agents", type=int, default=1000)
    parser.add_argument("--heap", default="1g", help="as REVE_HEAP (1g)")
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--reve", default=str(ROOT / "reve"), help="the command reve")
    sys.exit(0 if measure(parser.parse_args()) else 1)


if __name__ == "__main__":
    main()
