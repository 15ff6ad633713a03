# SPDX-License-Identifier: Apache-2.0
"""Tests of the client's protocol state, without a connection."""

import unittest

from reve import protocol
from reve.conversation import Conversation


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
