#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sends mutated messages to a running server, beside an agent that does its work.

    tests/siege/messages.py [--count 500000] [--seed N] [WORLD]

Starts `./reve serve WORLD --port 0` (worlds/workshop unless given), measures how many perceptions
a second an innocent agent gets alone, then sends COUNT messages from several connections at once:
the vectors of agents/protocol with bytes changed, cut, doubled and spliced, numbers and texts
replaced, objects nested, in both encodings, before and after a valid hello. Prints one JSON object:
messages, connections, the codes of the answers, the innocent agent's rates, its longest gap, the
server's peak memory, and `held`: whether the server still answers and the agent kept 0.95 of its
rate. Exits with 1 if it did not hold. The seed makes the messages the same again.
"""

import argparse
import collections
import json
import random
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
VECTORS = ROOT / "agents/protocol/vectors"
HOST = "127.0.0.1"
ATTACKERS = 4
MESSAGES_PER_CONNECTION = 12  # the server closes after eight errors
BASELINE_SECONDS = 10
PATIENCE_SECONDS = 60
KEPT_RATE = 0.95
# These messages change the world correctly, so their mutants show nothing about the server.
LEFT_OUT = {"pause", "run", "step", "rewind", "shut-down"}

NUMBERS = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "9007199254740993",
    "1e999",
    "NaN",
    "0.1e",
    "00",
    "18446744073709551616",
    "9" * 400,
    "-0",
    "1E+2",
    "0x10",
]
TEXTS = [
    "",
    "a" * 70,
    "a" * 70000,
    "\\u0000",
    "\\ud83e",
    "\\u202e",
    "\\u2028",
    "../../etc/passwd",
    "\\n\\u001b[31mfault",
    "iron",
    "bellows",
    "actor",
    "$1/0",
    "(a{1000}){1000}",
    "ﷺ",
    "🦆",
]


def seeds():
    """Returns valid messages of clients as (JSON line, packed bytes or None)."""
    lines = []
    for line in (VECTORS / "client.jsonl").read_text().splitlines():
        if json.loads(line)["t"] not in LEFT_OUT:
            lines.append(line)
    for item, action, arguments in [
        ("iron", "take", {}),
        ("iron", "strike", {"strength": 0.5}),
        ("iron", "lay", {"on": "anvil"}),
        ("bellows", "pump", {"what": "iron", "by": 100}),
        ("weight", "pull", {"force": [1, 2, 3]}),
        ("weight", "cut", {}),
    ]:
        lines.append(
            json.dumps(
                {"t": "act", "id": 1, "item": item, "action": action, "arguments": arguments}
            )
        )
    packed = [
        bytes.fromhex(entry["bytes"])
        for entry in map(json.loads, (VECTORS / "packed.jsonl").read_text().splitlines())
        if entry["from"] == "client" and entry["message"]["t"] not in LEFT_OUT
    ]
    return lines, packed


def mutate_text(rng, line, others):
    """Returns a mutant of a JSON line as bytes without the newline."""
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        kind = rng.randrange(7)
        at = rng.randrange(len(line) + 1)
        if kind == 0:
            sign = chr(rng.choice((rng.randrange(128), rng.randrange(0xD800))))
            line = line[:at] + sign + line[at + 1 :]
        elif kind == 1:
            line = line[:at]
        elif kind == 2:
            end = min(len(line), at + rng.randrange(1, 40))
            line = line[:end] + line[at:end] * rng.choice((1, 3, 200)) + line[end:]
        elif kind == 3:
            line = line.replace(rng.choice(("1", "0.5", "60", "0", "true")), rng.choice(NUMBERS), 1)
        elif kind == 4:
            parts = line.split('"')
            if len(parts) > 2:
                parts[rng.randrange(1, len(parts), 2)] = rng.choice(TEXTS)
            line = '"'.join(parts)
        elif kind == 5:
            other = rng.choice(others)
            line = line[:at] + other[rng.randrange(len(other)) :]
        else:
            depth = rng.choice((3, 31, 33, 5000))
            line = line.replace(":", ":" + "[" * depth + "1" + "]" * depth + ',"x":', 1)
    return line.replace("\n", " ").encode("utf-8", "replace")


def mutate_packed(rng, data):
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        at = rng.randrange(len(data)) if data else 0
        kind = rng.randrange(4)
        if kind == 0 and data:
            data[at] = rng.randrange(256)
        elif kind == 1:
            del data[at : at + rng.randrange(1, 8)]
        elif kind == 2:
            data[at:at] = rng.randbytes(rng.randrange(1, 16))
        else:
            data[at : at + 1] = rng.choice(
                (
                    b"\xdd\xff\xff\xff\xff",
                    b"\xdf\x7f\xff\xff\xff",
                    b"\xdb\xff\xff\xff\xff",
                    b"\xc6\x7f\xff\xff\xff",
                    b"\x91" * 40,
                    b"\xc1",
                    b"\xc7\xff\x01",
                )
            )
    return bytes(data)


class Attack(threading.Thread):
    """One attacker. It opens one connection after another, until its share of the messages is
    sent."""

    def __init__(self, number, port, count, seed):
        super().__init__(daemon=True)
        self.number, self.port, self.count = number, port, count
        self.rng = random.Random(seed * 1000 + number)
        self.lines, self.packed = seeds()
        self.codes = collections.Counter()
        self.sent = self.connections = 0
        self.failure = None

    def run(self):
        try:
            while self.sent < self.count:
                self.connect_once()
        except Exception as failure:  # the main thread reports it
            self.failure = failure

    def connect_once(self):
        rng = self.rng
        self.connections += 1
        name = f"mallory-{self.number}-{self.connections}"
        packed = rng.random() < 0.3
        hello = {"t": "hello", "protocol": 1, "name": name}
        if packed:
            hello["encoding"] = "msgpack"
        if rng.random() < 0.2:
            hello["role"] = "observer"
        if rng.random() < 0.1:
            hello["time"] = {"mode": "lock-step", "deadline": 0.001}
        first = json.dumps(hello)
        if rng.random() < 0.15:
            first = mutate_text(rng, first, self.lines).decode("utf-8", "replace")
        message = [first.encode() + b"\n"]
        for _ in range(MESSAGES_PER_CONNECTION):
            if packed:
                message.append(mutate_packed(rng, rng.choice(self.packed)))
            else:
                message.append(mutate_text(rng, rng.choice(self.lines), self.lines) + b"\n")
        self.sent += len(message)
        with socket.create_connection((HOST, self.port), PATIENCE_SECONDS) as connection:
            connection.settimeout(PATIENCE_SECONDS)
            try:
                connection.sendall(b"".join(message))
                connection.shutdown(socket.SHUT_WR)
                self.count_codes(connection)
            except (ConnectionResetError, BrokenPipeError):
                self.codes["reset"] += 1

    def count_codes(self, connection):
        received = b""
        while chunk := connection.recv(65536):
            received += chunk
        for part in received.split(b'"code":"')[1:]:
            self.codes[part.split(b'"', 1)[0].decode("ascii", "replace")] += 1
        for part in received.split(b"\xa4code")[1:]:
            length = part[0] & 0x1F
            self.codes[part[1 : 1 + length].decode("ascii", "replace")] += 1


class Innocent(threading.Thread):
    """An agent that perceives every frame and sometimes acts. It keeps the times of perceptions."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port = port
        self.times = []
        self.accepted = 0
        self.failure = None

    def run(self):
        try:
            with socket.create_connection((HOST, self.port), PATIENCE_SECONDS) as connection:
                connection.settimeout(PATIENCE_SECONDS)

                def send(message):
                    connection.sendall(json.dumps(message).encode() + b"\n")

                send({"t": "hello", "protocol": 1, "name": "innocent"})
                send({"t": "perceive", "every": 1})
                for line in connection.makefile("rb"):
                    kind = json.loads(line)["t"]
                    if kind == "perception":
                        self.times.append(time.monotonic())
                        if len(self.times) % 60 == 0:
                            send(
                                {
                                    "t": "act",
                                    "id": len(self.times),
                                    "item": "weight",
                                    "action": "pull",
                                    "arguments": {"force": [0, 1, 0]},
                                }
                            )
                    elif kind == "ping":
                        send({"t": "pong"})
                    elif kind == "result":
                        self.accepted += b'"accepted":true' in line
                    elif kind == "bye":
                        raise ConnectionError(line.decode())
        except Exception as failure:
            self.failure = failure

    def rate(self, begin, end):
        return sum(begin <= at < end for at in self.times) / (end - begin)

    def longest_gap(self, begin, end):
        times = [begin, *(at for at in self.times if begin <= at < end), end]
        return max(after - before for before, after in zip(times, times[1:]))


def peak_mib(pid):
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) // 1024


def attack(port, pid, count, seed):
    innocent = Innocent(port)
    innocent.start()
    time.sleep(2)
    begin = time.monotonic()
    time.sleep(BASELINE_SECONDS)
    alone = innocent.rate(begin, time.monotonic())
    attackers = [Attack(n, port, count // ATTACKERS, seed) for n in range(ATTACKERS)]
    begin = time.monotonic()
    for attacker in attackers:
        attacker.start()
    while any(attacker.is_alive() for attacker in attackers):
        time.sleep(5)
        print(f"{sum(a.sent for a in attackers)} of {count} messages", file=sys.stderr)
    end = time.monotonic()
    beside = innocent.rate(begin, end)
    codes = sum((attacker.codes for attacker in attackers), collections.Counter())
    failures = [repr(each.failure) for each in [innocent, *attackers] if each.failure]
    alive = Path(f"/proc/{pid}").exists()
    return {
        "seed": seed,
        "messages": sum(a.sent for a in attackers),
        "connections": sum(a.connections for a in attackers),
        "seconds": round(end - begin, 1),
        "perceptionsPerSecondAlone": round(alone, 1),
        "besideTheSiege": round(beside, 1),
        "longestGapSeconds": round(innocent.longest_gap(begin, end), 3),
        "actsAccepted": innocent.accepted,
        "serverPeakMiB": peak_mib(pid) if alive else None,
        "codes": dict(codes.most_common()),
        "failures": failures,
        "held": alive and not failures and beside >= KEPT_RATE * alone,
    }


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("world", nargs="?", default=str(ROOT / "worlds/workshop"))
    parser.add_argument("--count", type=int, default=500_000, help="messages (500000)")
    parser.add_argument("--seed", type=int, default=random.randrange(10**9))
    options = parser.parse_args()
    server = subprocess.Popen(
        [ROOT / "reve", "serve", options.world, "--port", "0", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        ready = json.loads(server.stdout.readline())
        for stream in (server.stdout, server.stderr):
            threading.Thread(target=collections.deque, args=(stream, 0), daemon=True).start()
        report = attack(int(ready["agentPort"]), int(ready["pid"]), options.count, options.seed)
    finally:
        server.terminate()
        server.wait(PATIENCE_SECONDS)
    report["exitCode"] = server.returncode
    report["held"] = report["held"] and server.returncode == 0
    print(json.dumps(report, indent=1))
    sys.exit(0 if report["held"] else 1)


if __name__ == "__main__":
    main()
