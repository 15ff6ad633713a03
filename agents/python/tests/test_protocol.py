"""The protocol's test vectors, as every client must reproduce them."""

import json
import math
import unittest

from support import vectors

from reve import ProtocolError, protocol


def written(message):
    """The JSON that a server must have sent for the client to understand this message."""
    t = type(message).__name__.lower()
    fields = {name: value for name, value in vars(message).items() if value is not None}
    if t == "welcome":
        limits = fields.pop("limits")
        fields["limits"] = {
            "lineBytes": limits.line_bytes,
            "actsInFlight": limits.acts_in_flight,
            "idleSeconds": limits.idle_seconds,
            "graceSeconds": limits.grace_seconds,
        }
        if message.session is not None:
            fields["session"] = {"token": message.session.token, "graceSeconds": message.session.grace_seconds}
        if not message.resumed:
            del fields["resumed"]
    if t == "perception":
        fields["items"] = [item(i) for i in message.items]
    return {"t": t, **fields}


def item(perceived):
    fields = {"name": perceived.name, "symbols": perceived.symbols}
    if perceived.location is not None:
        fields["location"] = list(perceived.location)
    fields["actions"] = {
        action: {name: {k: v for k, v in vars(p).items() if v is not None} for name, p in parameters.items()}
        for action, parameters in perceived.actions.items()
    }
    return fields


def said(message):
    """What this client writes for a message with those values."""
    t = message["t"]
    if t == "hello":
        resume = message.get("resume")
        return protocol.hello(
            message["name"], message.get("body"), message.get("role", protocol.AGENT), message.get("graceSeconds", 0),
            None if resume is None else (resume["session"], resume["frame"]),
        )
    if t == "perceive":
        return protocol.perceive(message["id"], message.get("every"), message.get("relations", False))
    if t == "act":
        return protocol.act(message["id"], message["item"], message["action"], message["arguments"])
    if t == "ping":
        return protocol.ping(message["id"])
    if t in ("pong", "bye"):
        return {"pong": protocol.pong, "bye": protocol.bye}[t]()
    return protocol.command(message["id"], t, **{k: v for k, v in message.items() if k not in ("t", "id")})


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
                self.assertEqual(written(protocol.decode(json.dumps(message).encode())), message)

    def test_an_unusual_form_means_the_same(self):
        for vector in vectors("lenient.jsonl"):
            if vector["from"] == "server":
                with self.subTest(line=vector["line"]):
                    means = json.dumps(vector["means"]).encode()
                    self.assertEqual(protocol.decode(vector["line"].encode()), protocol.decode(means))

    def test_what_is_no_message_is_refused_and_shown(self):
        for line in (
            b"", b"null", b"[]", b"{}", b'{"t":1}', b'{"t":"jump"}', b'{"t":"hello"}', b'{"t":"bye"', b"\xff\xfe",
            b'{"t":"result","id":1}', b'{"t":"perception","frame":1,"time":0,"items":[{"name":"a"}]}',
        ):
            with self.subTest(line=line), self.assertRaises(ProtocolError) as raised:
                protocol.decode(line)
            self.assertEqual(raised.exception.code, "protocol")

    def test_a_number_that_is_not_finite_is_never_sent(self):
        for value in (math.nan, math.inf, [0.0, -math.inf]):
            with self.subTest(value=value), self.assertRaises(ValueError):
                protocol.encode(protocol.act(1, "duck", "push", {"impulse": value}))


if __name__ == "__main__":
    unittest.main()
