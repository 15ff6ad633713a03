# SPDX-License-Identifier: Apache-2.0
"""Tests of the asyncio client with a real server."""

import asyncio
import unittest

import reve
import reve.aio
from support import pond


class AsyncAgentTest(unittest.IsolatedAsyncioTestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = pond()
        cls.port = cls.server.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__(None, None, None)

    def join(self, name, **options):
        return reve.aio.connect("127.0.0.1", self.port, name=name, **options)

    async def test_an_agent_perceives_acts_and_hears(self):
        async with await self.join("ada") as ada:
            self.assertEqual(ada.name, "ada")
            self.assertIn(ada.body, ("boat", "ada"))  # the boat may not be free yet
            self.assertTrue(await ada.act("duck", "paint", colour="red"))
            self.assertEqual((await ada.act("swan", "paint")).code, "no-such-item")
            self.assertEqual((await ada.perceive()).find("duck").symbols["colour"], "red")
            self.assertIn("acted", [event.type for event in ada.events()])
            await ada.ping()

    async def test_what_one_agent_says_is_in_the_next_perception_of_another(self):
        async with await self.join("ann") as ann, await self.join("ben") as ben:
            said = await ann.say("bread and butter")
            self.assertTrue(said, said)
            (heard,) = (await ben.perceive()).heard
            self.assertEqual((heard.frame, heard.text), (said.frame, "bread and butter"))
            self.assertEqual((heard.speaker, heard.lost), (ann.body, 0))
            self.assertEqual((await ben.perceive()).heard, ())
            self.assertEqual((await ann.say("x" * 257)).code, "wrong-type")

    async def test_a_stream_brings_the_newest_perceptions_until_it_is_left(self):
        async with await self.join("bob") as bob:
            frames = []
            async for perception in bob.perceptions(every=2):
                frames.append(perception.frame)
                if len(frames) == 5:
                    break
            self.assertEqual(frames, sorted(set(frames)))

    async def test_agents_step_together(self):
        time = reve.LockStep(deadline=600.0)
        async with (
            await self.join("cyd", time=time) as cyd,
            await self.join("dan", time=time) as dan,
        ):
            first = await dan.observe()
            await cyd.observe(first.frame)
            for number in range(1, 20):
                seen = await asyncio.gather(
                    cyd.step(reve.Act("duck", "paint", {"colour": f"shade {number}"})), dan.step()
                )
                frames = [perception.frame for perception in seen]
                self.assertEqual(frames, [first.frame + number] * 2)
                self.assertEqual(seen[1].find("duck").symbols["colour"], f"shade {number}")
                self.assertTrue(seen[0].results[0])

    async def test_a_broken_connection_comes_back_and_nothing_is_done_twice(self):
        async with await self.join("eve", grace=600.0) as eve:
            for number in range(5):
                eve._wire.writer.transport.abort()
                self.assertTrue(await eve.act("duck", "paint", colour=f"shade {number}"))
            acted = [e for e in eve.events() if e.type == "acted" and e.fields["agent"] == "eve"]
            self.assertEqual(len(acted), 5)

    async def test_who_may_not_join_is_told_why_and_who_has_left_too(self):
        async with await self.join("fay") as fay:
            with self.assertRaises(reve.Disconnected) as raised:
                await self.join("fay")
            self.assertEqual(raised.exception.code, "name-taken")
        with self.assertRaises(reve.Disconnected) as raised:
            await fay.ping()
        self.assertEqual(raised.exception.code, "closed")

    async def test_control_pauses_and_steps(self):
        async with await reve.aio.control("127.0.0.1", self.port) as boss:
            paused = await boss.pause()
            self.assertEqual((await boss.step(5)).frame, paused.frame + 5)
            self.assertTrue(await boss.run())


if __name__ == "__main__":
    unittest.main()
