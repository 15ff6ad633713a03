# SPDX-License-Identifier: Apache-2.0
"""Clients of programs that are no servers of worlds, or faulty ones."""

import asyncio
import json
import socket
import threading
import time
import unittest

import reve
import reve.aio

WELCOME = {
    "t": "welcome",
    "id": None,
    "protocol": 1,
    "role": "agent",
    "agent": "ada",
    "body": "duck",
    "world": "pond",
    "frame": 0,
    "rate": 60,
    "limits": {
        "lineBytes": 1,
        "messagesPerSecond": 1,
        "actsInFlight": 1,
        "idleSeconds": 1,
        "graceSeconds": 60,
    },
}
SESSION = {"session": {"token": "0" * 32, "graceSeconds": 60}}
DEEP = b"[" * 100_000 + b"\n"
PATIENCE = 600  # seconds after which a test fails; the clients' own limits are much shorter


def line(message):
    return json.dumps(message).encode() + b"\n"


class FakeServer:
    """Accepts connections and runs `talk` with each on a thread of its own."""

    def __init__(self, talk):
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = self._listening.getsockname()[1]
        self._talk = talk
        self._ends = threading.Event()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                connection, _ = self._listening.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        try:
            with connection:
                connection.recv(65536)  # the hello
                self._talk(connection, self._ends)
        except OSError:
            pass  # the client has left

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._ends.set()
        self.refuse()

    def refuse(self):
        """Accepts no more connections."""
        try:
            self._listening.shutdown(socket.SHUT_RDWR)  # also ends a wait for a connection
        except OSError:
            pass  # it was closed before
        self._listening.close()


def welcomes(connection, _):
    connection.sendall(line(WELCOME))
    connection.recv(65536)  # the bye


def sends_to(port):
    bye = {"t": "bye", "code": "moved", "message": "elsewhere", "address": f"127.0.0.1:{port}"}
    return lambda connection, _: connection.sendall(line(bye))


class Moved(unittest.TestCase):
    """Servers of a cluster that send a client to another one."""

    def test_the_client_joins_where_the_server_sends_it(self):
        with FakeServer(welcomes) as second, FakeServer(sends_to(second.port)) as first:
            with reve.connect("127.0.0.1", first.port, name="ada") as agent:
                self.assertEqual(agent.welcome.world, "pond")

            async def joins():
                async with await reve.aio.connect("127.0.0.1", first.port, name="ada") as agent:
                    return agent.welcome.world

            self.assertEqual(asyncio.run(joins()), "pond")

    def test_the_client_waits_while_the_world_starts(self):
        starting = {"t": "bye", "code": "world-starting", "message": "in a second"}
        answers = []

        def talk(connection, ends):
            answers.append(len(answers))
            if len(answers) % 3:
                connection.sendall(line(starting))
            else:
                welcomes(connection, ends)

        with FakeServer(talk) as server:
            with reve.connect("127.0.0.1", server.port, name="ada"):
                self.assertEqual(len(answers), 3)

            async def joins():
                async with await reve.aio.connect("127.0.0.1", server.port, name="ada"):
                    return len(answers)

            self.assertEqual(asyncio.run(joins()), 6)

    def test_a_session_continues_on_the_server_to_which_its_world_moves(self):
        starting = {"t": "bye", "code": "world-starting", "message": "in a second"}

        def moves(port):
            def talk(connection, _):
                connection.sendall(line({**WELCOME, **SESSION}))
                connection.recv(65536)  # the ping, which is not answered here
                sends_to(port)(connection, _)

            return talk

        attempts = []

        def continues(connection, _):
            attempts.append(len(attempts))
            if len(attempts) % 2:
                connection.sendall(line(starting))
                return
            connection.sendall(line({**WELCOME, **SESSION, "resumed": True}))
            connection.recv(65536)  # the same ping
            connection.sendall(line({"t": "pong", "id": 1}))
            connection.recv(65536)  # the bye

        with FakeServer(continues) as second, FakeServer(moves(second.port)) as first:
            with reve.connect("127.0.0.1", first.port, name="ada", grace=60) as agent:
                agent.ping()
            self.assertEqual(len(attempts), 2)

            async def pings():
                async with await reve.aio.connect(
                    "127.0.0.1", first.port, name="ada", grace=60
                ) as agent:
                    await agent.ping()

            asyncio.run(pings())
            self.assertEqual(len(attempts), 4)

    def test_a_session_continues_although_the_next_server_ends(self):
        ends = {"t": "bye", "code": "closing", "message": "the server ends"}
        calls = {"first": 0, "second": 0}

        def first_talk(port):
            def talk(connection, _):
                calls["first"] += 1
                if calls["first"] % 2:
                    connection.sendall(line({**WELCOME, **SESSION}))
                    connection.recv(65536)  # the ping, which is not answered here
                sends_to(port)(connection, _)

            return talk

        def second_talk(connection, _):
            calls["second"] += 1
            if calls["second"] % 2:
                connection.sendall(line(ends))
                return
            connection.sendall(line({**WELCOME, **SESSION, "resumed": True}))
            connection.recv(65536)  # the same ping
            connection.sendall(line({"t": "pong", "id": 1}))
            connection.recv(65536)  # the bye

        with FakeServer(second_talk) as second, FakeServer(first_talk(second.port)) as first:
            with reve.connect("127.0.0.1", first.port, name="ada", grace=60) as agent:
                agent.ping()
            self.assertEqual(calls, {"first": 2, "second": 2})

            async def pings():
                async with await reve.aio.connect(
                    "127.0.0.1", first.port, name="ada", grace=60
                ) as agent:
                    await agent.ping()

            asyncio.run(pings())
            self.assertEqual(calls, {"first": 4, "second": 4})

    def test_a_session_continues_on_a_server_that_the_welcome_names(self):
        def silent(connection, ends):
            ends.wait(PATIENCE)

        def continues(connection, _):
            connection.sendall(line({**WELCOME, **SESSION, "resumed": True}))
            connection.recv(65536)  # the ping again
            connection.sendall(line({"t": "pong", "id": 1}))
            connection.recv(65536)  # the bye

        def lost(others):
            def talk(connection, _):
                servers = [f"127.0.0.1:{other}" for other in others]
                session = {"session": {**SESSION["session"], "servers": servers}}
                connection.sendall(line({**WELCOME, **session}))
                connection.recv(65536)  # the ping, which is not answered here
                first.refuse()

            return talk

        with FakeServer(silent) as second, FakeServer(continues) as third:
            first = FakeServer(lost([second.port, third.port]))
            with reve.connect("127.0.0.1", first.port, name="ada", grace=60, timeout=300) as agent:
                agent.ping()
            first = FakeServer(lost([third.port]))

            async def pings():
                async with await reve.aio.connect(
                    "127.0.0.1", first.port, name="ada", grace=60
                ) as agent:
                    await agent.ping()

            asyncio.run(pings())

    def test_a_client_without_a_session_does_not_follow_its_world(self):
        def moves(connection, _):
            connection.sendall(line(WELCOME))
            connection.recv(65536)  # the ping
            sends_to(9)(connection, _)

        with FakeServer(moves) as server:
            with reve.connect("127.0.0.1", server.port, name="ada") as agent:
                with self.assertRaises(reve.Disconnected) as ended:
                    agent.ping()
                self.assertEqual(ended.exception.code, "moved")
                self.assertEqual(ended.exception.address, ("127.0.0.1", 9))

    def test_the_client_does_not_follow_for_ever(self):
        port = []
        circle = FakeServer(lambda connection, ends: sends_to(port[0])(connection, ends))
        with circle:
            port.append(circle.port)
            with self.assertRaises(reve.Disconnected) as refused:
                reve.connect("127.0.0.1", circle.port, name="ada")
            self.assertEqual(refused.exception.code, "moved")
            self.assertEqual(refused.exception.address, ("127.0.0.1", circle.port))

            async def joins():
                await reve.aio.connect("127.0.0.1", circle.port, name="ada")

            with self.assertRaises(reve.Disconnected):
                asyncio.run(joins())


def drip(data):
    """Returns the function of a server that sends these bytes ten times a second."""

    def talk(connection, ends):
        while not ends.wait(0.1):
            connection.sendall(data)

    return talk


def flood(data):
    def talk(connection, ends):
        while not ends.is_set():
            connection.sendall(data)

    return talk


def welcome_and(*messages, **more):
    """Returns the function of a server that welcomes the client and then sends these bytes."""

    def talk(connection, ends):
        connection.sendall(line({**WELCOME, **more}) + b"".join(messages))
        ends.wait()

    return talk


class HostileServerTest(unittest.TestCase):
    def setUp(self):
        self.began = time.monotonic()

    def tearDown(self):
        self.assertLess(time.monotonic() - self.began, PATIENCE)

    def joins(self, server, timeout=60):
        """Yields two functions that join: one for a blocking client and one for asyncio."""
        yield lambda **more: reve.connect(port=server.port, name="ada", timeout=timeout, **more)

        def join(**more):
            async def run():
                await reve.aio.connect(port=server.port, name="ada", timeout=timeout, **more)

            asyncio.run(run())

        yield join

    def test_the_timeout_limits_joining_whatever_the_server_sends(self):
        for talk in (drip(line({"t": "ping"})), drip(b" "), lambda _, ends: ends.wait()):
            with FakeServer(talk) as server:
                for join in self.joins(server, 0.5):
                    with self.assertRaises(reve.ReveError) as refused:
                        join()
                    self.assertEqual(refused.exception.code, "no-answer")

    def test_bytes_without_end_before_the_welcome_are_refused(self):
        with FakeServer(flood(b"x" * 65536)) as server:
            for join in self.joins(server):
                with self.assertRaises(reve.ProtocolError) as refused:
                    join()
                self.assertIn("expected at most", str(refused.exception))

    def test_what_is_no_welcome_is_a_protocol_error(self):
        for data in (DEEP, line({**WELCOME, "limits": 7}), line({**WELCOME, "session": [1]})):
            with FakeServer(welcome_and()) as server:
                server._talk = lambda connection, ends, data=data: connection.sendall(data)
                for join in self.joins(server):
                    self.assertRaises(reve.ProtocolError, join)

    def test_a_message_that_cannot_be_read_ends_the_session_with_its_reason(self):
        item = {"name": "a", "location": [1], "symbols": {}, "actions": {}}
        for data in (
            DEEP,
            line({"t": "perception", "frame": 1, "time": 0, "items": [item]}),
            line({"t": "event", "frame": "soon", "type": "said", "fields": {}}),
            line({"t": "event", "frame": None, "type": "said", "fields": {}}),
            line({"t": "event", "frame": 1, "type": "missed", "fields": []}),
            line({"t": "perception", "id": [], "frame": 1, "time": 0, "items": []}),
        ):
            with self.subTest(data=data[:60]), FakeServer(welcome_and(data)) as server:
                with reve.connect(port=server.port, name="ada", timeout=60) as ada:
                    with self.assertRaises(reve.ProtocolError):
                        ada.ping()

    def test_a_session_whose_grace_is_no_number_ends_with_its_reason(self):
        def talk(connection, _):
            connection.sendall(
                line({**WELCOME, "session": {"token": "0" * 32, "graceSeconds": "long"}})
            )

        with FakeServer(talk) as server:
            with reve.connect(port=server.port, name="ada", grace=60, timeout=60) as ada:
                with self.assertRaises(reve.ReveError) as ended:
                    ada.ping()
                self.assertNotEqual(ended.exception.code, "no-answer")

    def test_leaving_does_not_wait_for_a_server_that_never_resumes(self):
        first, joined, resumes = threading.Event(), threading.Event(), threading.Event()
        grace = 10 * PATIENCE
        session = {"session": {**SESSION["session"], "graceSeconds": grace}}

        def talk(connection, ends):
            if not first.is_set():
                first.set()
                connection.sendall(line({**WELCOME, **session}))
                joined.wait(PATIENCE)  # and closes the connection
            else:
                resumes.set()
                drip(line({"t": "ping"}))(connection, ends)

        with FakeServer(talk) as server:
            ada = reve.connect(port=server.port, name="ada", grace=grace, timeout=60)
            ada._timeout = 5  # of an attempt to resume; joining may take longer
            joined.set()
            self.assertTrue(resumes.wait(PATIENCE))
            ada.close()

    def test_the_time_for_many_events_of_one_frame_is_proportional_to_their_number(self):
        few, many = (self.seconds_for(events) for events in (15_000, 60_000))
        self.assertLess(many / few, 8)

    def seconds_for(self, events):
        """Returns the processor time of this process while a client receives these events."""
        event = line({"t": "event", "frame": 5, "type": "said", "fields": {}})

        def talk(connection, _):
            connection.sendall(line(WELCOME) + event * events)
            connection.recv(65536)  # the ping
            connection.sendall(line({"t": "pong", "id": 1}))

        began = time.process_time()
        with FakeServer(talk) as server:
            with reve.connect(port=server.port, name="ada", timeout=PATIENCE) as ada:
                ada.ping()
                self.assertEqual(len(ada.events()), 1024)
        return time.process_time() - began


if __name__ == "__main__":
    unittest.main()
