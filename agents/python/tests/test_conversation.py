# SPDX-License-Identifier: Apache-2.0
"""Tests of the client's protocol state, without a connection."""

import dataclasses
import ssl
import unittest

from reve import protocol
from reve.conversation import Conversation
from reve.tls import failed


def conversation():
    welcome = protocol.Welcome(
        None,
        1,
        "agent",
        "ada",
        "ada",
        "pond",
        1,
        60,
        "json",
        None,
        protocol.Ticket("secret", 60.0),
        False,
        protocol.Limits(65536, 4096, 64, 15.0, 60.0),
    )
    return Conversation(protocol.hello("ada", grace_seconds=60), welcome)


def said(frame):
    return protocol.Event(frame, "said", {})


def missed(first, last, **count):
    return protocol.Event(last, "missed", {**count, "first": first, "last": last})


class MissedEventsTest(unittest.TestCase):
    def setUp(self):
        self.talk = conversation()

    def frame_seen(self):
        return self.talk.greeting()["resume"]["frame"]

    def test_a_gap_is_an_event_a_count_and_a_warning(self):
        with self.assertLogs("reve", "WARNING") as log:
            for event in (said(3), missed(4, 9, events=12), said(10), missed(11, 12, events=1)):
                self.talk.take(event)
        self.assertEqual(1, len(log.output), log.output)
        self.assertIn("ada misses events from frame 4 to 9, as it reads too slowly", log.output[0])
        self.assertEqual(13, self.talk.missed_events)
        self.assertEqual(
            ["said", "missed", "said", "missed"], [event.type for event in self.talk.events()]
        )

    def test_a_gap_is_not_asked_for_again_after_a_break(self):
        with self.assertLogs("reve", "WARNING"):
            self.talk.take(missed(2, 9, events=12))
        self.assertEqual(9, self.frame_seen())
        self.talk.gone_on()
        self.talk.take(said(10))
        self.assertEqual([9, 10], [event.frame for event in self.talk.events()])

    def test_events_known_before_a_break_are_skipped_only_where_they_are_told_again(self):
        for frame in (5, 5, 5):
            self.talk.take(said(frame))
        self.assertEqual(4, self.frame_seen())
        self.talk.gone_on()
        with self.assertLogs("reve", "WARNING"):
            self.talk.take(missed(5, 8))  # the server has dropped those, too
        self.talk.take(said(9))
        self.assertEqual([5, 5, 5, 8, 9], [event.frame for event in self.talk.events()])
        self.assertEqual(1, self.talk.missed_events)


def heard(frame, text, **fields):
    return protocol.Event(
        frame, "heard", {"text": text, "direction": [0, 0, 1], "distance": 2.5, **fields}
    )


def perception(id, frame):
    return protocol.Perception(id, frame, frame / 60, ())


class ServersTest(unittest.TestCase):
    """Attempts to resume a session on the servers of a cluster."""

    FIRST, SECOND = ("10.0.0.1", 7777), ("10.0.0.2", 7777)

    def test_a_server_that_ends_in_the_handshake_is_left_for_another_one(self):
        talk = conversation()
        ended = failed(EOFError("the connection broke"))
        ended.__cause__ = EOFError()
        self.assertEqual(self.FIRST, talk.another_address(self.FIRST, ended))
        self.assertFalse(talk.may_retry(ended), "there is no other server")
        session = protocol.Ticket("secret", 60.0, (self.SECOND,))
        talk.know_servers(dataclasses.replace(talk.welcome, session=session))
        self.assertTrue(talk.may_retry(ended))
        self.assertEqual(self.SECOND, talk.another_address(self.FIRST, ended))
        untrusted = failed(ssl.SSLCertVerificationError("unknown authority"))
        untrusted.__cause__ = ssl.SSLCertVerificationError()
        self.assertFalse(talk.may_retry(untrusted))


class HeardTest(unittest.TestCase):
    def setUp(self):
        self.talk = conversation()

    def texts(self, seen):
        return [voice.text for voice in seen.heard]

    def test_what_is_heard_belongs_to_the_next_perception_that_is_returned(self):
        number, _ = self.talk.subscribe(1)
        self.talk.take(heard(3, "one", speaker="bob", lost=2))
        self.talk.take(perception(number, 3))
        self.talk.take(heard(4, "two"))
        self.talk.take(perception(number, 4))
        self.talk.take(heard(5, "three"))  # of a frame that is not perceived yet
        seen = self.talk.news(number)
        self.assertEqual(
            seen.heard,
            (
                protocol.Heard(3, "one", "bob", (0, 0, 1), 2.5, 2),
                protocol.Heard(4, "two", None, (0, 0, 1), 2.5),
            ),
        )
        self.talk.take(perception(number, 5))
        self.assertEqual(self.texts(self.talk.news(number)), ["three"])
        self.talk.take(perception(number, 6))
        self.assertEqual(self.texts(self.talk.news(number)), [])
        self.assertEqual([event.type for event in self.talk.events()], 3 * ["heard"])

    def test_a_single_perception_has_it_and_a_prediction_has_not(self):
        future, _ = self.talk.fork(60)
        number, _ = self.talk.question(protocol.perceive)
        self.talk.take(heard(7, "one"))
        self.talk.take(perception(future, 70))
        self.talk.take(perception(number, 7))
        self.assertEqual(self.texts(self.talk.foreseen(future)), [])
        self.assertEqual(self.texts(self.talk.answer(number, protocol.Perception)), ["one"])

    def test_what_was_heard_before_a_break_is_not_heard_again(self):
        number, _ = self.talk.subscribe(1)
        self.talk.take(heard(5, "one"))
        self.talk.gone_on()
        self.talk.take(heard(5, "one"))  # the server repeats the events after the last full frame
        self.talk.take(heard(5, "two"))
        self.talk.take(perception(number, 5))
        self.assertEqual(self.texts(self.talk.news(number)), ["one", "two"])
