#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Attacks a running server as its agents can, and measures what innocent agents get meanwhile.

    tests/siege/agents.py [--seconds 20] [--only ATTACK ...] [--json]

For each attack a server is started on tests/siege/square.yaml, library.yaml or
archive.yaml. Three innocent agents join: `steady`
perceives every frame, `slow` does too but reads nothing for 3 s of every 4, and `learner` is in
lock-step and ready at once. Their rates are measured alone, then beside the attack. Each attack
runs in processes of its own. A line tells perceptions a second of `steady` (which are the frames
of the world), its longest gap, which innocent agents were disconnected, which laws were
quarantined, and how many attackers still run at the end. An attack has succeeded if an agent was
disconnected, a law is gone, the server died, or `steady` has less than half of its rate. Exits with
1 if one has.
"""

import argparse
import collections
import functools
import json
import multiprocessing
import selectors
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
SQUARE = ROOT / "tests/siege/square.yaml"
LIBRARY = ROOT / "tests/siege/library.yaml"
ARCHIVE = ROOT / "tests/siege/archive.yaml"
HOST = "127.0.0.1"
BASELINE_SECONDS = 4
PATIENCE_SECONDS = 30
KEPT = 0.5
LOCK_STEP = {"mode": "lock-step", "deadline": 10}


class Client:
    """One connection; raises OSError when the server has closed it."""

    def __init__(self, port, name, **hello):
        self.socket = socket.create_connection((HOST, port), PATIENCE_SECONDS)
        self.lines = self.socket.makefile("rb")
        self.number = 0
        self.send({"t": "hello", "protocol": 1, "name": name, **hello})

    def send(self, *messages):
        self.socket.sendall(b"".join(json.dumps(m).encode() + b"\n" for m in messages))

    def act(self, item, action, arguments=None):
        self.number += 1
        return {
            "t": "act",
            "id": self.number,
            "item": item,
            "action": action,
            "arguments": arguments or {},
        }

    def read(self):
        line = self.lines.readline()
        if not line:
            raise ConnectionError("the server closed the connection")
        message = json.loads(line)
        if message["t"] == "ping":
            self.send({"t": "pong"})
        return message

    def await_(self, kind):
        while (message := self.read())["t"] != kind:
            if message["t"] == "bye":
                raise ConnectionError(message.get("code"))
        return message

    def close(self):
        self.lines.close()
        self.socket.close()


# ---- attacks: each gets the port and a number of its own, and runs until its process is ended ----


def flood(item, action, arguments):
    """Acts as fast as results arrive, with the maximum number of acts in flight."""

    def attack(port, me):
        client = Client(port, f"mallory-{me}")
        client.await_("welcome")
        client.send(*(client.act(item, action, arguments(n)) for n in range(60)))
        while True:
            if client.read()["t"] == "result":
                client.send(client.act(item, action, arguments(client.number)))

    return attack


def silent_lock_step(port, me):
    client = Client(port, f"mallory-{me}", time=LOCK_STEP)
    while True:
        client.read()


def late_lock_step(port, me):
    """Is ready just before its deadline."""
    client = Client(port, f"mallory-{me}", time=LOCK_STEP)
    deadline = client.await_("welcome")["time"]["deadline"]
    while True:
        client.await_("perception")
        time.sleep(0.95 * deadline)
        client.send({"t": "ready"})


def twice_late_lock_step(port, me):
    """Misses two of three rounds, so that it is never away."""
    client = Client(port, f"mallory-{me}", time=LOCK_STEP)
    rounds = 0
    while True:
        frame = client.await_("perception")["frame"]
        rounds += 1
        if rounds % 3 == 0:
            client.send({"t": "ready", "frame": frame})


def returning_lock_step(port, me):
    """Misses two rounds, leaves, and joins again under another name."""
    for n in range(10**9):
        client = Client(port, f"mallory-{me}-{n}", time=LOCK_STEP)
        try:
            client.await_("welcome")
            client.await_("perception")
            client.send({"t": "ready"})
            for _ in range(3):
                client.await_("perception")
        except OSError:
            time.sleep(0.01)
        client.close()


def leaving_lock_step(port, me):
    """Says nothing, and leaves when its next client has joined. Each client replaces the one
    before."""
    before = None
    for n in range(10**9):
        client = Client(port, f"mallory-{me}-{n}", time=LOCK_STEP)
        client.await_("welcome")
        if before:
            before.close()
        before = client
        time.sleep(0.9)


def joins(**hello):
    """Joins and leaves again and again, each time under a new name."""

    def attack(port, me):
        for n in range(10**9):
            client = Client(port, f"mallory-{me}-{n}", **hello)
            try:
                client.await_("welcome")
            except OSError:  # turned away, for example while the world is full
                time.sleep(0.01)
            client.close()

    return attack


def crowd(port, me):
    """As many agents as can join. Each perceives every frame."""
    clients = selectors.DefaultSelector()
    for n in range(500):
        try:
            client = Client(port, f"mallory-{me}-{n}")
            client.send({"t": "perceive", "every": 1, "relations": True})
        except OSError:
            break
        clients.register(client.socket, selectors.EVENT_READ)
    while True:
        for key, _ in clients.select():
            if not key.fileobj.recv(1 << 20):
                clients.unregister(key.fileobj)


def deaf(port, me):
    """Requests everything and reads nothing."""
    clients = []
    while True:
        try:
            client = Client(port, f"mallory-{me}-{len(clients)}")
            client.send({"t": "perceive", "every": 1, "relations": True})
            clients.append(client)
        except OSError:
            pass
        if len(clients) == 200:
            clients.pop(0).close()


def readers(port, me, again=False):
    """Observers of all items, who join again when they are disconnected.

    They read nothing, or request everything again five times per second.
    """
    clients = selectors.DefaultSelector()
    names = (f"mallory-{me}-{n}" for n in range(10**9))

    def join():
        client = Client(port, next(names), role="observer")
        client.send({"t": "perceive", "every": 1})
        client.socket.setblocking(False)
        clients.register(client.socket, selectors.EVENT_READ, client)

    def replace(key):
        clients.unregister(key.fileobj)
        key.data.close()
        join()

    for _ in range(150):
        join()
    asked = time.monotonic()
    while True:
        for key, _ in clients.select(0.05) if again else ():
            if not key.fileobj.recv(1 << 20):
                replace(key)
        time.sleep(0.01)
        if time.monotonic() - asked > 0.2:
            asked = time.monotonic()
            for key in list(clients.get_map().values()):
                try:
                    key.data.send({"t": "perceive", "every": 1})
                except BlockingIOError:
                    pass
                except OSError:
                    replace(key)


def fill(port, me, acts=None):
    """Changes the lists of all shelves one after the other. Joins again under another name after
    some acts."""
    shelves = [f"shelf {i} {j}" for i in range(1, 41) for j in range(1, 26)]
    for n in range(10**9):
        client = Client(port, f"mallory-{me}-{n}")
        client.await_("welcome")
        begun = min(acts or 60, 60)
        client.send(*(client.act(shelves[k], "fill", {"first": f"{me} {n}"}) for k in range(begun)))
        results = 0
        while acts is None or results < acts:
            if client.read()["t"] == "result":
                results += 1
                if acts is None:
                    shelf = shelves[client.number % len(shelves)]
                    client.send(client.act(shelf, "fill", {"first": f"{me} {client.number}"}))
        client.close()


def mute(port, me):
    """Connections that never send a hello, or send it with one byte per second."""
    waiting = []
    while True:
        try:
            connection = socket.create_connection((HOST, port), PATIENCE_SECONDS)
            connection.sendall(b"{")
            waiting.append(connection)
        except OSError:
            pass
        if len(waiting) == 800:
            waiting.pop(0).close()


def long_lines(port, me):
    """Acts with the longest text that a line can have."""
    for n in range(10**9):
        client = Client(port, f"mallory-{me}-{n}")
        try:
            client.await_("welcome")
            while True:
                client.send(
                    *(client.act("crier", "shout", {"text": "x" * 65000}) for _ in range(20))
                )
                client.await_("result")
        except OSError:
            client.close()


def nested_lines(port, me):
    """Fifty clients that send lines of 59,000 brackets, as fast as the server reads them."""
    line = ('{"t":"pong","x":[' + ",".join(["[" * 29 + "]" * 29] * 1000) + "]}\n").encode()
    clients = selectors.DefaultSelector()
    names = (f"mallory-{me}-{n}" for n in range(10**9))

    def join():
        client = Client(port, next(names))
        client.socket.setblocking(False)
        clients.register(client.socket, selectors.EVENT_WRITE, [client, line])

    for _ in range(50):
        join()
    while True:
        for key, _ in clients.select(1):
            client, rest = key.data
            try:
                sent = client.socket.send(rest)
                key.data[1] = rest[sent:] or line
            except BlockingIOError:
                pass
            except OSError:
                clients.unregister(client.socket)
                client.close()
                join()


# ---- what they send ----

WORDS = ["x" * 1000, "\u202e\x1b[31m" * 200, "\U0001f986" * 250]
BAD = [1e-320, 1e-160, 5e-324, 1e-99, 1e99, 1e100, 1e30, 0, 1, 1e-12]


def knead(n):
    return {
        "mass": BAD[n % 10],
        "inertia": [BAD[n // 10 % 10], BAD[n // 100 % 10], BAD[n % 7]],
        "spin": [BAD[n // 3 % 10], BAD[n // 7 % 10], 1],
    }


def push(n):
    return {"force": [BAD[n % 10], BAD[n // 10 % 10], 0], "impulse": [BAD[n // 7 % 10], 0, 0]}


def deform(port, me):
    """Sets and pushes in turn, so that every value meets every other."""
    client = Client(port, f"mallory-{me}")
    client.await_("welcome")
    for n in range(me * 500, 10**9):
        client.send(client.act("clay", "knead", knead(n)), client.act("clay", "push", push(n)))
        client.await_("result")
        client.await_("result")


ATTACKS = {
    "nothing": ([], "no attack: what the measurement itself costs"),
    "items": ([flood("mint", "strike", lambda n: {})] * 2, "items without end"),
    "words": (
        [flood("crier", "shout", lambda n: {"text": WORDS[n % 3]})] * 2,
        "events with texts of 1,000 characters",
    ),
    "acts": ([flood("crier", "shout", lambda n: {"text": ""})] * 2, "acts without end"),
    "questions": (
        [flood("oracle", "ask", lambda n: {"number": n})] * 2,
        "conditions that take almost 20,000 steps",
    ),
    "values": ([deform] * 2, "masses, inertias and forces of any size"),
    "silent": ([silent_lock_step] * 2, "lock-step without a word"),
    "late": ([late_lock_step] * 2, "lock-step, ready just before each deadline"),
    "twice-late": ([twice_late_lock_step] * 3, "lock-step, two rounds of three missed"),
    "returning": ([returning_lock_step] * 3, "lock-step, ever anew under other names"),
    "leaving": ([leaving_lock_step], "lock-step without a word, gone before each deadline"),
    "grace": ([joins(graceSeconds=60)] * 2, "bodies left behind with graceSeconds"),
    "coming": ([joins()] * 2, "agents that come and go"),
    "crowd": ([crowd] * 2, "1,000 agents that perceive every frame, with relations"),
    "deaf": ([deaf] * 2, "400 agents that ask for everything and read nothing"),
    "readers": ([readers] * 2, "300 observers of 5,000 long texts, who read nothing", LIBRARY),
    "again": (
        [functools.partial(readers, again=True)] * 2,
        "300 observers who ask for 5,000 long texts five times a second",
        LIBRARY,
    ),
    "rules": (
        [fill] * 2,
        "acts that change what 25 costly rules read, of 1,000 items",
        ARCHIVE,
    ),
    "rules-anew": (
        [functools.partial(fill, acts=3)] * 2,
        "the same under ever new names",
        ARCHIVE,
    ),
    "mute": ([mute] * 2, "1,600 connections that never say hello"),
    "lines": ([long_lines] * 2, "lines of 65,000 characters"),
    "nested": ([nested_lines] * 2, "100 clients that send lines of 59,000 brackets"),
}


def run_attack(attack, port, me):
    try:
        attack(port, me)
    except OSError as e:  # a disconnect is also an answer
        print(f"  attacker {me}: {e}", file=sys.stderr)


class Innocent(threading.Thread):
    """An agent that perceives. It keeps the times of its perceptions, and the reason why its
    connection ended."""

    def __init__(self, port, name, pause=0.0, **hello):
        super().__init__(daemon=True, name=name)
        self.pause = pause
        self.client = Client(port, name, **hello)
        self.in_lock_step = "time" in hello
        self.times = collections.deque()
        self.quarantined = set()
        self.ended = None

    def run(self):
        try:
            if not self.in_lock_step:
                self.client.send({"t": "perceive", "every": 1})
            awake = time.monotonic()
            while True:
                if self.pause and time.monotonic() - awake > 1:
                    time.sleep(self.pause)
                    awake = time.monotonic()
                self.take(self.client.read())
        except (OSError, ValueError) as e:
            self.ended = self.ended or str(e)

    def take(self, message):
        kind = message["t"]
        if kind == "perception":
            self.times.append(time.monotonic())
            if self.in_lock_step:
                self.client.send({"t": "ready"})
        elif kind == "event" and message["type"] == "fault":
            fields = message["fields"]
            if "library" in fields and not fields.get("arrested"):
                self.quarantined.add(fields["library"])
        elif kind == "bye":
            self.ended = message.get("code")

    def rate(self, begin, end):
        return sum(begin <= at < end for at in list(self.times)) / (end - begin)

    def longest_gap(self, begin, end):
        times = [begin, *(at for at in list(self.times) if begin <= at < end), end]
        return max(after - before for before, after in zip(times, times[1:]))


def besiege(name, seconds):
    attackers, what, world = (*ATTACKS[name], SQUARE)[:3]
    server = subprocess.Popen(
        [ROOT / "reve", "serve", world, "--port", "0", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    processes = []
    try:
        ready = json.loads(server.stdout.readline())
        port, pid = int(ready["agentPort"]), int(ready["pid"])
        threading.Thread(target=collections.deque, args=(server.stdout, 0), daemon=True).start()
        innocent = [
            Innocent(port, "steady"),
            Innocent(port, "slow", pause=3),
            Innocent(port, "learner", time={"mode": "lock-step", "every": 6}),
        ]
        for agent in innocent:
            agent.start()
        time.sleep(2)
        begin = time.monotonic()
        time.sleep(BASELINE_SECONDS)
        alone = innocent[0].rate(begin, time.monotonic())
        processes = [
            multiprocessing.Process(target=run_attack, args=(attack, port, n), daemon=True)
            for n, attack in enumerate(attackers)
        ]
        for process in processes:
            process.start()
        begin = time.monotonic()
        time.sleep(seconds)
        end = time.monotonic()
        steady = innocent[0]
        beside = steady.rate(begin, end)
        report = {
            "attack": name,
            "what": what,
            "attackers": len(attackers),
            "alone": round(alone, 1),
            "beside": round(beside, 1),
            "learner": round(innocent[2].rate(begin, end), 1),
            "longestGapSeconds": round(steady.longest_gap(begin, end), 2),
            "disconnected": {each.name: each.ended for each in innocent if each.ended},
            "quarantined": sorted(steady.quarantined),
            "serverMiB": peak_mib(pid) if server.poll() is None else None,
        }
        report["attackersLeft"] = sum(process.is_alive() for process in processes)
        report["held"] = (
            server.poll() is None
            and not report["disconnected"]
            and not report["quarantined"]
            and beside >= KEPT * alone
        )
        return report
    finally:
        for process in processes:
            process.kill()
        server.terminate()
        server.wait(PATIENCE_SECONDS)


def peak_mib(pid):
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) // 1024


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=20, help="of each attack (20)")
    parser.add_argument(
        "--only",
        nargs="+",
        choices=list(ATTACKS),
        metavar="ATTACK",
        help="one or more of " + ", ".join(ATTACKS),
    )
    parser.add_argument("--json", action="store_true", help="one JSON object an attack")
    options = parser.parse_args()
    held = True
    if not options.json:
        print(
            "| attack | perceptions/s alone | beside | longest gap [s] | learner's rounds/s "
            "| disconnected, quarantined | server [MiB] | attackers left |\n"
            "|---|---|---|---|---|---|---|---|"
        )
    for name in options.only or ATTACKS:
        report = besiege(name, options.seconds)
        held &= report["held"]
        if options.json:
            print(json.dumps(report), flush=True)
        else:
            lost = [f"{n}: {code}" for n, code in report["disconnected"].items()]
            lost += report["quarantined"]
            print(
                f"| {report['what']} | {report['alone']} | {report['beside']} "
                f"| {report['longestGapSeconds']} | {report['learner']} "
                f"| {', '.join(lost) or '–'} | {report['serverMiB']} "
                f"| {report['attackersLeft']} of {report['attackers']} |",
                flush=True,
            )
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
