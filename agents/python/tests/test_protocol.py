# SPDX-License-Identifier: Apache-2.0
"""The protocol's test vectors, which every client must reproduce."""

import base64
import json
import math
import unittest

import reve
from reve import ProtocolError, protocol
from support import vectors

try:
    import msgpack
except ImportError:
    msgpack = None


def received(data):
    """Returns the first message in these received bytes."""
    incoming = protocol.Incoming(protocol.MSGPACK if msgpack else protocol.JSON)
    incoming.feed(data)
    return incoming.next()


def written(message):
    """Returns the JSON that a server must have sent for the client to decode this message."""
    t = type(message).__name__.lower()
    fields = {
        name: value
        for name, value in vars(message).items()
        if value is not None and name not in ("results", "heard")
    }
    if t == "welcome":
        limits = fields.pop("limits")
        every = {
            "lineBytes": limits.line_bytes,
            "messagesPerSecond": limits.messages_per_second,
            "actsInFlight": limits.acts_in_flight,
            "idleSeconds": limits.idle_seconds,
            "graceSeconds": limits.grace_seconds,
            "items": limits.items,
            "worldItems": limits.world_items,
            "eventBytes": limits.event_bytes,
            "worldEventBytes": limits.world_event_bytes,
        }
        fields["limits"] = {name: most for name, most in every.items() if most is not None}
        time, session = message.time, message.session
        if time is not None:
            fields["time"] = {"mode": "lock-step", "every": time.every, "deadline": time.deadline}
        if session is not None:
            fields["session"] = {"token": session.token, "graceSeconds": session.grace_seconds}
            if session.servers:
                servers = [f"{host}:{port}" for host, port in session.servers]
                fields["session"]["servers"] = servers
        if not message.resumed:
            del fields["resumed"]
        fields["cameras"] = list(message.cameras)
        if not message.cameras:
            del fields["cameras"]
        if message.encoding == protocol.JSON:
            del fields["encoding"]
    if t == "image":
        for layer in ("colour", "depth", "items"):
            if layer in fields:
                fields[layer] = base64.b64encode(fields[layer]).decode()
        fields["names"] = list(message.names)
        return {"t": t, **{k: v for k, v in fields.items() if v != []}}
    if t in ("perception", "update"):
        fields.pop("readings")
        if message.readings:
            fields["readings"] = {
                sensor: {"frame": one.frame, **{k: list(v) for k, v in one.quantities.items()}}
                for sensor, one in message.readings.items()
            }
    if t == "perception":
        fields["items"] = [item(i) for i in message.items]
    if t == "update":
        fields["left"] = list(message.left)
        fields["entered"] = [item(i) for i in message.entered]
        fields["changed"] = [item(i) for i in message.changed]
        return {"t": "perception", **{k: v for k, v in fields.items() if v != []}}
    if "address" in fields:
        fields["address"] = "{}:{}".format(*fields["address"])
    return {"t": t, **fields}


def item(perceived):
    fields = {k: v for k, v in vars(perceived).items() if v is not None}
    for vector in ("location", "orientation"):
        if vector in fields:
            fields[vector] = list(fields[vector])
    if isinstance(perceived, reve.Item):
        if perceived.orientation == protocol.NOT_TURNED:
            del fields["orientation"]
        fields["capabilities"] = list(perceived.capabilities)
        for sensed in ("symbols", "actions", "needs", "capabilities"):
            if not fields[sensed]:
                del fields[sensed]
    if "actions" in fields:
        fields["actions"] = {
            action: {
                name: {k: v for k, v in vars(p).items() if v is not None}
                for name, p in parameters.items()
            }
            for action, parameters in perceived.actions.items()
        }
    return fields


def understood(message):
    """Returns a server message without fields that are omitted on the wire, e.g. an empty
    `actions`."""
    if message["t"] == "image":
        return message
    for one in message.get("items", []) + message.get("entered", []):
        for sensed in ("symbols", "actions"):
            if one.get(sensed) == {}:
                del one[sensed]
    return message


def lock_step(time):
    fallback = time.get("fallback")
    act = (
        None
        if fallback is None
        else protocol.Act(fallback.get("item"), fallback["action"], fallback["arguments"])
    )
    return protocol.LockStep(
        time.get("every", 1), time.get("deadline", 1.0), act, time.get("relations", False)
    )


def said(message):
    """Returns the message that this client encodes from the given values."""
    t = message["t"]
    if "ask" in message:
        return protocol.ask(message["ask"], message["name"], message.get("token"))
    if t == "hello":
        resume, time = message.get("resume"), message.get("time")
        return protocol.hello(
            message["name"],
            message.get("body"),
            message.get("role", protocol.AGENT),
            message.get("encoding", protocol.JSON),
            message.get("graceSeconds", 0),
            None if resume is None else (resume["session"], resume["frame"]),
            message.get("token"),
            None if time is None else lock_step(time),
            message.get("world"),
        )
    if t == "perceive":
        return protocol.perceive(
            message["id"], message.get("every"), message.get("relations", False)
        )
    if t == "look":
        return protocol.look(message["id"], message["sensor"], message.get("item"))
    if t == "act":
        act = protocol.act(message["id"], message["item"], message["action"], message["arguments"])
        return protocol.and_ready(act, message.get("frame")) if message.get("ready") else act
    if t == "ready":
        return protocol.ready(message.get("frame"))
    if t == "ping":
        return protocol.ping(message["id"])
    if t in ("pong", "bye"):
        return {"pong": protocol.pong, "bye": protocol.bye}[t]()
    fields = {k: v for k, v in message.items() if k not in ("t", "id")}
    return protocol.command(message["id"], t, **fields)


class ProtocolTest(unittest.TestCase):
    def test_what_the_client_says_is_written_as_documented(self):
        for message in vectors("client.jsonl"):
            with self.subTest(message=message):
                line = protocol.encode(said(message))
                self.assertEqual(line.count(b"\n"), 1)
                self.assertTrue(line.endswith(b"\n"))
                self.assertEqual(json.loads(line), message)

    def test_what_the_server_says_is_understood(self):
        session = [line["server"] for line in vectors("session.jsonl") if "server" in line]
        for message in vectors("server.jsonl") + session:
            with self.subTest(message=message):
                read = protocol.decode(json.dumps(message).encode())
                self.assertEqual(written(read), understood(message))

    @unittest.skipUnless(msgpack, "needs the package msgpack")
    def test_messagepack_says_the_same(self):
        for vector in vectors("packed.jsonl"):
            with self.subTest(message=vector["message"]):
                frame, message = bytes.fromhex(vector["bytes"]), vector["message"]
                if vector["from"] == "server":
                    self.assertEqual(written(received(frame)), understood(message))
                else:
                    encoded = protocol.encode(said(message), protocol.MSGPACK)
                    self.assertEqual(int.from_bytes(encoded[:4], "big"), len(encoded) - 4)
                    self.assertEqual(msgpack.unpackb(encoded[4:]), message)

    @unittest.skipUnless(msgpack, "needs the package msgpack")
    def test_a_packed_number_that_is_not_finite_is_never_sent(self):
        act = protocol.act(1, "duck", "push", {"impulse": [0.0, math.nan]})
        with self.assertRaises(ValueError):
            protocol.encode(act, protocol.MSGPACK)

    def test_a_connection_that_ends_within_a_message_has_ended_there(self):
        pong = {"t": "pong", "id": 1}
        for encoding in (protocol.JSON, protocol.MSGPACK) if msgpack else (protocol.JSON,):
            whole = protocol.encode(pong, encoding)
            for length in range(len(whole)):
                with self.subTest(encoding=encoding, length=length):
                    self.assertIsNone(received(whole[:length]))
            self.assertEqual(received(whole), protocol.Pong(1))

    def test_messages_arrive_whole_however_a_connection_cuts_them(self):
        pongs = [protocol.Pong(number) for number in (1, 2_000, 3)]
        encodings = [protocol.JSON, protocol.MSGPACK if msgpack else protocol.JSON, protocol.JSON]
        messages = [{"t": "pong", "id": pong.id} for pong in pongs]
        whole = b"".join(map(protocol.encode, messages, encodings))
        for size in range(1, len(whole) + 1):
            with self.subTest(size=size):
                incoming, taken = protocol.Incoming(encodings[1]), []
                for begin in range(0, len(whole), size):
                    incoming.feed(whole[begin : begin + size])
                    message = incoming.next()
                    while message is not None:
                        taken.append(message)
                        message = incoming.next()
                self.assertEqual(taken, pongs)

    @unittest.skipIf(msgpack is None, "needs the package msgpack")
    def test_a_packed_message_of_more_than_16_mib_is_read(self):
        text = "x" * (17 << 20)
        whole = protocol.encode(
            {"t": "event", "frame": 1, "type": "said", "fields": {"text": text}}, protocol.MSGPACK
        )
        self.assertNotEqual(whole[0], 0, "the length needs its first byte")
        incoming = protocol.Incoming(protocol.MSGPACK)
        incoming.limit = protocol.MOST_BYTES
        incoming.feed(whole)
        self.assertEqual(incoming.next(), protocol.Event(1, "said", {"text": text}))

    def test_a_message_beyond_the_limit_is_refused_before_it_is_complete(self):
        for encoding, data in [
            (protocol.JSON, b"x" * 1001),
            (protocol.MSGPACK, (1001).to_bytes(4, "big")),
            (protocol.MSGPACK, b"HTTP/1.1 400 Bad Request"),
            (protocol.MSGPACK, b"{" + b" " * 1000),
        ]:
            with self.subTest(encoding=encoding, data=data[:10]):
                incoming = protocol.Incoming(encoding)
                incoming.limit = 1000
                incoming.feed(data)
                with self.assertRaisesRegex(ProtocolError, "expected at most 1000 bytes"):
                    incoming.next()

    def test_a_message_that_is_none_leaves_the_next_one_readable(self):
        incoming = protocol.Incoming(protocol.JSON)
        incoming.feed(b'nonsense\n{"t":"pong","id":1}\n')
        self.assertRaises(reve.ProtocolError, incoming.next)
        self.assertEqual(incoming.next(), protocol.Pong(1))

    def test_updates_add_up(self):
        messages = [protocol.decode(json.dumps(m).encode()) for m in vectors("server.jsonl")]
        first = next(m for m in messages if isinstance(m, reve.Perception) and m.id == 2)
        perception = first
        for update in (m for m in messages if isinstance(m, reve.Update)):
            perception = perception.updated(update)
        boat, duck = perception.items
        self.assertEqual((boat.name, boat.location), ("boat", (3.0, 0.0, 0.5)))
        self.assertEqual(boat.orientation, (0.0, 0.0, 0.0, 1.0))
        self.assertEqual((boat.symbols["class"], list(boat.actions)), ("wreck", ["raise"]))
        self.assertEqual((duck.name, duck.location, duck.actions), ("duck", (1.0, 0.0, -2.5), {}))
        with self.assertRaises(ProtocolError):
            first.updated(next(m for m in messages if isinstance(m, reve.Update) and m.since == 6))

    def test_an_item_belongs_to_its_class_and_those_above_it(self):
        line = {
            "t": "perception",
            "frame": 1,
            "time": 0.1,
            "items": [
                {"name": "mug", "symbols": {"class": "cup", "classes": ["cup", "vessel", "body"]}},
                {"name": "pot", "symbols": {"class": "vessel", "note": ["cup"]}},
                {"name": "sign", "symbols": {"classes": "vessel"}},
                {"name": "fog"},
            ],
        }
        mug, pot, sign, fog = protocol.decode(json.dumps(line).encode()).items
        self.assertTrue(mug.is_a("cup") and mug.is_a("vessel") and mug.is_a("body"))
        self.assertTrue(pot.is_a("vessel"))
        self.assertFalse(mug.is_a("pot") or pot.is_a("cup") or pot.is_a("body"))
        self.assertFalse(sign.is_a("vessel") or sign.is_a("v") or fog.is_a("cup"))

    def test_readings_are_arrays_of_doubles_and_stay_until_the_next_ones(self):
        first = protocol.decode(
            b'{"t":"perception","frame":5,"time":0.5,"items":[],"readings":{"imu":{"frame":4,'
            b'"specificForce":[0,9.81,-1e-3],"angularVelocity":[0.5,0,0]}}}'
        )
        force = memoryview(first.readings["imu"]["specificForce"])
        self.assertEqual((force.format, force.shape, force.tolist()), ("d", (3,), [0, 9.81, -1e-3]))
        quiet = protocol.decode(b'{"t":"perception","frame":6,"time":0.6,"since":5}')
        self.assertEqual(first.updated(quiet).readings, first.readings)
        news = protocol.decode(
            b'{"t":"perception","frame":7,"time":0.7,"since":6,"readings":{"imu":{"frame":7,'
            b'"specificForce":[1,2,3],"angularVelocity":[4,5,6]}}}'
        )
        last = first.updated(quiet).updated(news).readings["imu"]
        self.assertEqual((last.frame, list(last["angularVelocity"])), (7, [4, 5, 6]))
        with self.assertRaises(KeyError):
            last["distances"]
        with self.assertRaises(ProtocolError):
            protocol.decode(
                b'{"t":"perception","frame":1,"time":0,"items":[],"readings":{"imu":{"frame":1,'
                b'"specificForce":["x"]}}}'
            )

    def test_a_ray_that_met_nothing_has_an_infinite_distance(self):
        scan = protocol.decode(
            b'{"t":"perception","frame":5,"time":0.5,"items":[],"readings":{"scan":{"frame":5,'
            b'"columns":2,"distances":[1.5,-1,0,7]}}}'
        ).readings["scan"]
        self.assertEqual(list(scan["distances"]), [1.5, math.inf, 0.0, 7.0])
        self.assertEqual((scan.columns, scan.frame), (2, 5))

    def test_an_unusual_form_means_the_same(self):
        for vector in vectors("lenient.jsonl"):
            if vector["from"] == "server":
                with self.subTest(line=vector["line"]):
                    means = protocol.decode(json.dumps(vector["means"]).encode())
                    self.assertEqual(protocol.decode(vector["line"].encode()), means)

    def test_what_is_no_message_is_refused_and_shown(self):
        for line in (
            b"",
            b"null",
            b"[]",
            b"{}",
            b'{"t":1}',
            b'{"t":"jump"}',
            b'{"t":"hello"}',
            b'{"t":"bye"',
            b"\xff\xfe",
            b'{"t":"result","id":1}',
            b'{"t":"perception","frame":1,"time":0,"items":[{}]}',
        ):
            with self.subTest(line=line), self.assertRaises(ProtocolError) as raised:
                protocol.decode(line)
            self.assertEqual(raised.exception.code, "protocol")

    def test_a_number_that_is_not_finite_is_never_sent(self):
        for value in (math.nan, math.inf, [0.0, -math.inf]):
            with self.subTest(value=value), self.assertRaises(ValueError):
                protocol.encode(protocol.act(1, "duck", "push", {"impulse": value}))


class PerceptionTest(unittest.TestCase):
    def test_an_item_is_found_by_its_name(self):
        duck = reve.Item("duck", (0.0, 1.0, 0.0), {}, {})
        perception = reve.Perception(None, 7, 0.5, (duck,))
        self.assertIs(perception["duck"], duck)
        with self.assertRaisesRegex(KeyError, "no item 'swan' was perceived in frame 7"):
            perception["swan"]


if __name__ == "__main__":
    unittest.main()
