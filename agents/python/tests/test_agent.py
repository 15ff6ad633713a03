# SPDX-License-Identifier: Apache-2.0
"""Tests of the client with a real server in a separate process that makes 240 frames per second."""

import concurrent.futures
import contextlib
import importlib.util
import itertools
import json
import os
import socket
import subprocess
import sys
import threading
import time
import unittest

import reve
from cutter import Cutter
from support import ENVIRONMENT, PACKAGE, PATIENCE, java, pond


class AgentTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.servers = contextlib.ExitStack()
        cls.port = cls.servers.enter_context(pond())

    @classmethod
    def tearDownClass(cls):
        cls.servers.close()

    def join(self, name, **options):
        agent = reve.connect("127.0.0.1", self.port, name=name, **options)
        self.addCleanup(agent.close)
        return agent

    def test_an_agent_is_welcomed_with_its_body_and_the_worlds_name(self):
        # A body is free again after this refusal, because agents that left earlier return their
        # bodies before the frame of the refusal.
        with self.assertRaises(reve.Disconnected) as raised:
            self.join("ada", body="duck")
        self.assertEqual(raised.exception.code, "no-such-body")
        with self.join("ada", body="boat") as ada, self.join("bob") as bob:
            self.assertEqual((ada.name, ada.body), ("ada", "boat"))
            self.assertEqual((ada.welcome.world, ada.welcome.rate), ("pond", 240))
            self.assertEqual((bob.name, bob.body), ("bob", "bob"))
            names = [item.name for item in bob.perceive().items]
            self.assertEqual(names, ["duck", "boat", "rope", "anchor", "bob"])

    def test_a_perception_has_places_symbols_and_actions(self):
        with self.join("eve") as eve:
            perception = eve.perceive()
            # The welcome may arrive before its frame is published. That frame is then the next
            # frame.
            self.assertGreaterEqual(perception.frame, eve.welcome.frame)
            self.assertIsNotNone(perception.find(eve.body))
            self.assertAlmostEqual(perception.time, perception.frame / 240)
            duck, rope = perception.find("duck"), perception.find("rope")
            self.assertEqual(duck.location, (1.0, 0.0, -2.5))
            self.assertEqual(duck.symbols["class"], "toy")
            self.assertEqual(duck.actions["push"], {"impulse": reve.Parameter("number", 3, "N*s")})
            self.assertEqual(duck.actions["paint"], {"colour": reve.Parameter("text")})
            self.assertIsNone(rope.location)
            self.assertIsNone(perception.find("swan"))

    def test_perceptions_come_every_n_frames_and_only_while_asked_for(self):
        with self.join("fay") as fay:
            frames = []
            for perception in fay.perceptions(every=5):
                frames.append(perception.frame)
                if len(frames) == 4:
                    break
            self.assertTrue(all(b - a >= 5 for a, b in zip(frames, frames[1:])), frames)
            self.assertGreater(fay.perceive().frame, frames[-1])

    def test_another_stream_ends_the_first(self):
        with self.join("gus") as gus:
            first, second = gus.perceptions(every=1), gus.perceptions(every=2)
            next(first)
            next(second)
            self.assertEqual(list(first), [])
            self.assertGreater(next(second).frame, 0)

    def test_an_act_takes_effect_in_the_frame_that_its_result_names(self):
        with self.join("hal") as hal:
            result = hal.act("duck", "paint", colour="grün")
            self.assertTrue(result)
            perception = hal.perceive()
            self.assertGreaterEqual(perception.frame, result.frame)
            self.assertEqual(perception.find("duck").symbols["colour"], "grün")

    def test_a_refused_act_is_a_result_with_code_and_reason(self):
        with self.join("ian") as ian:
            for arguments, code in (
                ({}, "missing-argument"),
                ({"impulse": [1, 2]}, "wrong-components"),
            ):
                result = ian.act("duck", "push", **arguments)
                self.assertFalse(result)
                self.assertEqual(result.code, code)
                self.assertIn("impulse", result.reason)
            self.assertEqual(ian.act("swan", "push").code, "no-such-item")

    def test_events_are_kept_in_order_and_handed_out_once(self):
        with self.join("jan") as jan:
            duck = jan.perceive().find("duck")
            jan.act(duck, "push", impulse=[0, 0, 0])
            jan.perceive()
            events = [
                event
                for event in jan.events()
                if event.fields.get("actor") == jan.body or event.fields.get("agent") == "jan"
            ]
            self.assertEqual([event.type for event in events], ["joined", "quack", "acted"])
            self.assertEqual([e for e in jan.events() if e.fields.get("agent") == "jan"], [])

    def test_a_name_is_taken_while_its_agent_is_there(self):
        with self.join("kim"):
            with self.assertRaises(reve.Disconnected) as raised:
                self.join("kim")
            self.assertEqual(raised.exception.code, "name-taken")
            self.assertIn("another name", raised.exception.hint)
        self.join("kim").close()

    def test_leaving_removes_the_body(self):
        with self.join("lea") as lea:
            with self.join("max"):
                self.assertIsNotNone(lea.perceive().find("max"))
            lea.perceive()  # may be of a frame that had begun when max left
            self.assertIsNone(lea.perceive().find("max"))

    def test_a_refused_message_raises_its_code_and_the_agent_goes_on(self):
        with self.join("nat") as nat:
            with self.assertRaises(reve.ReveError) as raised:
                nat.act("", "push")
            self.assertEqual(raised.exception.code, "bad-field")
            nat.ping()

    def test_after_closing_every_call_says_so(self):
        ola = self.join("ola")
        ola.close()
        ola.close()
        for call in (
            ola.perceive,
            ola.ping,
            lambda: ola.act("duck", "push"),
            lambda: next(ola.perceptions()),
        ):
            with self.assertRaises(reve.Disconnected) as raised:
                call()
            self.assertEqual(raised.exception.code, "closed")

    def test_several_threads_share_an_agent(self):
        with self.join("pia") as pia:
            accepted = []

            def paint(number):
                for _ in range(10):
                    accepted.append(pia.act("duck", "paint", colour=f"shade {number}").accepted)

            threads = [threading.Thread(target=paint, args=(number,)) for number in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(accepted, [True] * 40)

    def test_the_end_of_the_server_ends_every_call_with_its_reason(self):
        with contextlib.ExitStack() as stack:
            port = stack.enter_context(pond())
            agent = reve.connect("127.0.0.1", port, name="ray")
            perceptions = agent.perceptions()
            next(perceptions)
            stack.close()
            with self.assertRaises(reve.Disconnected) as raised:
                for _ in perceptions:
                    pass
            self.assertEqual(raised.exception.code, "closing")
            agent.close()

    def test_a_server_that_says_nothing_costs_no_more_than_the_timeout(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            with self.assertRaises(reve.ReveError) as raised:
                reve.connect("127.0.0.1", silent.getsockname()[1], name="sam", timeout=0.2)
        self.assertEqual(raised.exception.code, "no-answer")

    def test_messagepack_does_all_that_json_does(self):
        try:
            import msgpack  # noqa: F401
        except ImportError:
            self.skipTest("needs the package msgpack")
        with self.join("mia", encoding="msgpack", grace=600.0) as mia:
            self.assertEqual(mia.welcome.encoding, "msgpack")
            perceptions = mia.perceptions()
            before = next(perceptions).find("duck")
            self.assertTrue(mia.act("duck", "paint", colour="blau"))
            mia._wire.socket.shutdown(socket.SHUT_RDWR)
            self.assertEqual(mia.act("swan", "paint").code, "no-such-item")
            while next(perceptions).find("duck").symbols["colour"] != "blau":
                pass
            self.assertEqual(next(perceptions).find("duck").location, before.location)
            self.assertEqual(mia.perceive().find("duck").actions, before.actions)

    def test_a_controller_joins_by_its_own_function(self):
        with self.assertRaisesRegex(ValueError, "use control"):
            self.join("boss", role="control")

    def test_an_observer_perceives_without_a_body(self):
        with self.join("eye", role="observer") as eye:
            self.assertIsNone(eye.body)
            self.assertIsNotNone(eye.perceive().find("duck"))
            with self.assertRaises(reve.ReveError) as raised:
                eye.act("duck", "paint", colour="red")
            self.assertEqual(raised.exception.code, "not-permitted")

    def test_control_pauses_steps_edits_and_shuts_down(self):
        with pond() as port, reve.control("127.0.0.1", port) as boss:
            paused = boss.pause()
            self.assertEqual(boss.step(5).frame, paused.frame + 5)
            boss.run()
            self.assertTrue(boss.edit("duck", "semantic.class", "bird"))
            self.assertEqual(boss.perceive().find("duck").symbols["class"], "bird")
            self.assertEqual(boss.load_law("drag", unknown=2.0).code, "law-refused")
            self.assertTrue(boss.load_law("newton_motion"))
            self.assertTrue(boss.unload_law("newton_motion"))
            wrong = boss.load_law("up.law", text="law up\n  each body: force += velocity\n")
            self.assertEqual(wrong.code, "law-refused")
            self.assertIn("up.law:2:23: 'velocity' is a vector in m/s", wrong.reason)
            right = "law up\n  parameter f = 1 N\n  each body: force.y += f\n"
            self.assertTrue(boss.load_law(text=right, f=2.0))
            self.assertTrue(boss.load_law(text=right))
            self.assertTrue(boss.unload_law("up"))
            self.assertTrue(boss.shut_down())

    def test_control_asks_for_the_state_and_the_aspects_of_an_item(self):
        with pond() as port, reve.control("127.0.0.1", port) as boss:
            state = boss.state()
            self.assertEqual(state.of, "state")
            self.assertEqual([client["name"] for client in state.content["clients"]], ["control"])
            self.assertTrue(boss.speed(2))
            self.assertEqual(boss.state().content["speed"], 2)
            self.assertNotIn("roundTripSeconds", boss.state().content["clients"][0])
            with self.assertRaises(reve.ReveError) as refused:
                boss.audit("ada", most=5)
            self.assertEqual(refused.exception.code, "unsupported")
            boss.state(round_trips=True)
            end = time.monotonic() + PATIENCE
            while "roundTripSeconds" not in boss.state().content["clients"][0]:
                self.assertLess(time.monotonic(), end, "the client answers pings by itself")
            duck = boss.inspect("duck").content
            location = next(p for p in duck["physical"] if p["name"] == "location")
            self.assertEqual(location["unit"], "m")
            self.assertIn("push", [action["name"] for action in duck["access"]["actions"]])
            with self.assertRaises(reve.ReveError) as refused:
                boss.inspect("swan")
            self.assertEqual(refused.exception.code, "no-such-item")
            self.assertEqual(set(boss.laws().content), {"loaded", "quarantined", "available"})

    def test_control_rebuilds_the_world(self):
        with pond() as port, reve.control("127.0.0.1", port) as boss:
            reed = {"physical": {"shape": "box", "size": "1 100 1 cm"}}
            added = boss.add(
                {"name": "reed {i}", "repeat": 2, "like": "reed"},
                {"name": "hook", "physics": {"mass": 0}},
                prefabs={"reed": reed},
            )
            self.assertTrue(added, added)
            self.assertTrue(boss.change("rope", physics={"end2": "hook"}))
            self.assertTrue(boss.remove("anchor"))
            self.assertEqual(boss.remove("hook").code, "edit-refused")
            self.assertTrue(boss.change("reed 0", name="stick", semantic={"worn": True}))
            self.assertTrue(boss.rule("heavy", "physics.mass > 1.0"))
            seen = boss.perceive()
            self.assertIsNone(seen.find("anchor"))
            self.assertEqual(seen.find("stick").symbols["worn"], True)
            self.assertEqual(seen.find("stick").symbols["dimensions"], [0.01, 1.0, 0.01])
            self.assertEqual(seen.find("duck").symbols["heavy"], True)
            refused = boss.batch(
                {"t": "remove", "item": "stick"},
                {"t": "change", "item": "swan", "to": {"name": "goose"}},
            )
            self.assertEqual(refused.code, "no-such-item")
            self.assertTrue(boss.change("stick", semantic={"worn": None}))
            self.assertTrue(boss.rule("heavy", None))
            seen = boss.perceive()
            self.assertNotIn("worn", seen.find("stick").symbols)
            self.assertNotIn("heavy", seen.find("duck").symbols)

    def test_control_goes_back_and_looks_ahead(self):
        with pond() as port, reve.control("127.0.0.1", port) as boss:
            self.assertTrue(boss.edit("duck", "physics.velocity", [0, 3, 0]))
            self.assertTrue(boss.load_law("newton_motion"))
            stream = boss.perceptions()
            next(stream)
            boss.pause()
            self.assertTrue(boss.snapshot("rising"))
            first = boss.rewind("rising").frame
            start = next(seen for seen in stream if seen.frame == first)
            ahead = boss.foresee(24)
            last = boss.step(24).frame
            lived = next(seen for seen in stream if seen.frame == last)
            self.assertEqual((ahead.time, ahead.items), (lived.time, lived.items))
            self.assertGreater(lived.find("duck").location[1], start.find("duck").location[1])
            again = boss.rewind("rising").frame
            rewound = next(seen for seen in stream if seen.frame == again)
            self.assertEqual(rewound.items, start.items)
            begin = boss.rewind().frame
            self.assertEqual(next(seen for seen in stream if seen.frame == begin).time, 0.0)
            self.assertEqual(boss.rewind("falling").code, "no-such-image")
            self.assertEqual(boss.save("elsewhere").code, "unsupported")

    def test_an_agent_whose_connection_breaks_goes_on_as_if_nothing_had_happened(self):
        with self.join("pam", grace=600.0) as pam, self.join("quy") as quy:
            perceptions = pam.perceptions()
            before = next(perceptions)
            for number in range(5):
                pam._wire.socket.shutdown(socket.SHUT_RDWR)
                self.assertTrue(pam.act("duck", "paint", colour=f"shade {number}"))
            self.assertIsNotNone(quy.perceive().find(pam.body))
            self.assertGreater(next(perceptions).frame, before.frame)
            acted = [e for e in pam.events() if e.type == "acted" and e.fields["agent"] == "pam"]
            self.assertEqual(len(acted), 5)

    def test_an_agent_in_lock_step_perceives_what_its_acts_made_of_the_next_frame(self):
        with self.join("una", time=reve.LockStep(deadline=600.0)) as una:
            self.assertEqual(una.welcome.time.deadline, 600.0)
            before = una.observe()
            self.assertEqual(before.frame, una.welcome.frame)
            for number in range(20):
                duck = reve.Act("duck", "paint", {"colour": f"shade {number}"})
                after = una.step(duck, reve.Act("swan", "paint"))
                self.assertEqual(after.frame, before.frame + 1)
                self.assertEqual(after.find("duck").symbols["colour"], f"shade {number}")
                self.assertEqual([result.code for result in after.results], [None, "no-such-item"])
                before = after
            self.assertEqual(una.step().frame, before.frame + 1)
            self.assertEqual([e for e in una.events() if e.type == "late"], [])

    def test_rounds_of_several_frames_and_several_agents(self):
        with self.join("wim", time=reve.LockStep(deadline=0.0)) as wim:
            with self.join("vic", time=reve.LockStep(every=3, deadline=600.0)) as vic:
                frame = vic.observe().frame
                wim.ready(reve.Act("duck", "push", {"impulse": [0.0, 0.0, 0.0]}))
                self.assertEqual(vic.step().frame, frame + 3)
                self.assertTrue(all(wim.observe().results))

    def test_who_is_late_is_told_and_catches_up(self):
        fallback = reve.Act("duck", "paint", {"colour": "late"})
        with self.join("xia", time=reve.LockStep(deadline=0.01, fallback=fallback)) as xia:
            first = xia.observe()
            later = xia.observe(first.frame + 5)
            self.assertGreaterEqual(later.frame, first.frame + 5)
            self.assertEqual(later.find("duck").symbols["colour"], "late")
            self.assertTrue(xia.step(reve.Act("duck", "paint", {"colour": "red"})).results[0])
            own = [e for e in xia.events() if e.fields.get("agent") == "xia"]
            told = [e.type for e in own if e.type in ("late", "away", "back")]
            self.assertEqual(told[:5], ["late", "late", "late", "away", "back"])
            counts = [e.fields["count"] for e in own if e.type == "late"]
            self.assertEqual(counts[:3], [1, 2, 3])

    def test_an_edit_is_answered_while_the_world_waits_for_a_silent_agent(self):
        with self.join("zoe", time=reve.LockStep(deadline=600.0)) as zoe:
            with reve.control("127.0.0.1", self.port) as boss:
                frame = zoe.observe().frame
                self.assertEqual(boss.edit("duck", "semantic.colour", "grey").frame, frame + 1)
                self.assertEqual(zoe.step().find("duck").symbols["colour"], "grey")
                self.assertEqual([e for e in zoe.events() if e.type == "late"], [])

    def test_an_agent_in_lock_step_goes_on_after_a_break(self):
        with self.join("yan", time=reve.LockStep(deadline=600.0), grace=600.0) as yan:
            perception = yan.observe()
            for number in range(5):
                yan._wire.socket.shutdown(socket.SHUT_RDWR)
                after = yan.step(reve.Act("duck", "paint", {"colour": f"shade {number}"}))
                self.assertGreater(after.frame, perception.frame)
                self.assertTrue(after.results[0])
                perception = after
            acted = [e for e in yan.events() if e.type == "acted" and e.fields["agent"] == "yan"]
            self.assertEqual(len(acted), 5)

    def test_every_act_is_done_once_and_told_once_wherever_the_connection_is_cut(self):
        seed = int(os.environ.get("REVE_TEST_SEED", time.time_ns()))
        print(f"seed of the cuts: REVE_TEST_SEED={seed}")
        encodings = ("json", "msgpack") if importlib.util.find_spec("msgpack") else ("json",)
        paint = reve.Act("duck", "paint", {"colour": "red"})
        with self.join("eye", role="observer") as eye:
            rhythms = (None, reve.LockStep(deadline=600.0))
            for encoding, lock_step in itertools.product(encodings, rhythms):
                name = f"cut-{encoding}-{'step' if lock_step else 'free'}"
                cutter = Cutter(self.port, seed, 3000)
                with (
                    self.subTest(name, seed=seed),
                    cutter as way,
                    reve.connect(
                        port=way.port, name=name, encoding=encoding, time=lock_step, grace=600.0
                    ) as agent,
                ):
                    for _ in range(30):
                        if lock_step:
                            self.assertTrue(agent.step(paint).results[0])
                        else:
                            self.assertTrue(agent.act("duck", "paint", colour="red"))
                    # The call below returns after the events of the last act have arrived.
                    agent.step() if lock_step else agent.perceive()
                    with concurrent.futures.ThreadPoolExecutor(1) as others:
                        seen = others.submit(eye.perceive)
                        # The world makes a frame for the other one only if this agent steps.
                        while lock_step and not seen.done():
                            agent.step()
                        seen.result()
                    self.assertGreater(way.cuts, 0)
                    for client in (agent, eye):
                        acted = [
                            event
                            for event in client.events()
                            if event.type == "acted" and event.fields["agent"] == name
                        ]
                        self.assertEqual(len(acted), 30)

    def test_only_who_is_in_lock_step_steps(self):
        with self.join("zoe") as zoe:
            for call in (zoe.step, zoe.ready, zoe.observe):
                with self.assertRaises(reve.ReveError) as raised:
                    call()
                self.assertEqual(raised.exception.code, "not-lock-step")
        with self.join("abe", time=reve.LockStep()) as abe:
            with self.assertRaises(reve.ReveError) as raised:
                next(abe.perceptions())
            self.assertEqual(raised.exception.code, "lock-step")

    def test_the_curious_example_follows_and_pushes_what_is_interesting(self):
        example = subprocess.run(
            [
                sys.executable,
                str(PACKAGE / "examples" / "curious.py"),
                "--port",
                str(self.port),
                "--seconds",
                "0.5",
                "--push-every",
                "0.1",
            ],
            env={"PYTHONPATH": ENVIRONMENT["PYTHONPATH"]},
            stdout=subprocess.PIPE,
            text=True,
            timeout=PATIENCE,
            check=True,
        )
        summary = json.loads(example.stdout.splitlines()[-1])
        said = (summary["agent"], summary["world"], summary["ended"])
        self.assertEqual(said, ("curious", "pond", "done"))
        self.assertEqual(summary["favourite"], "duck")
        self.assertGreaterEqual(summary["pushes"], 2)
        self.assertGreaterEqual(summary["events"]["quack"], 1)
        self.assertGreaterEqual(summary["lastFrame"] - summary["firstFrame"], 120)

    def test_the_java_example_paints_what_lets_itself_be_painted(self):
        example = subprocess.run(
            java("reve.agent.examples.Painter", "--port", str(self.port), "--seconds", "0.5"),
            stdout=subprocess.PIPE,
            text=True,
            timeout=PATIENCE,
            check=True,
        )
        summary = json.loads(example.stdout.splitlines()[-1])
        said = (summary["agent"], summary["world"], summary["ended"])
        self.assertEqual(said, ("painter", "pond", "done"))
        self.assertEqual(summary["painted"], {"duck": "#0040ff"})
        self.assertEqual((summary["actsAccepted"], summary["actsRefused"]), (1, {}))

    def test_a_file_of_certificates_that_is_none_is_named(self):
        with self.assertRaises(FileNotFoundError) as missing:
            self.join("ada", tls="missing.crt")
        self.assertEqual(missing.exception.filename, "missing.crt")
        self.assertIn("certificates", missing.exception.strerror)
        with self.assertRaises(reve.Disconnected) as none:
            self.join("ada", tls=__file__)
        self.assertEqual(none.exception.code, "tls-failed")
        self.assertIn(__file__, str(none.exception))
        self.assertIn("PEM", none.exception.hint)

    def test_where_no_server_answers_is_named(self):
        with socket.create_server(("127.0.0.1", 0)) as listening:
            port = listening.getsockname()[1]
        with self.assertRaisesRegex(ConnectionRefusedError, f"127.0.0.1:{port}.*server"):
            reve.connect("127.0.0.1", port, name="ada")


if __name__ == "__main__":
    unittest.main()
