# SPDX-License-Identifier: Apache-2.0
"""Tests of the learning environments with the checkers of Gymnasium and PettingZoo, on real servers
with real physics."""

import importlib.util
import json
import re
import socket
import subprocess
import sys
import time
import unittest
import warnings

import pytest
import reve
from support import ENVIRONMENT, PACKAGE, PATIENCE

ROOT = PACKAGE.parents[1]
LAUNCHER = ROOT / "reve"
HAS_GYM = all(importlib.util.find_spec(package) for package in ("gymnasium", "numpy", "pettingzoo"))
EXPECTED_WARNINGS = ".*(infinity|spec|symmetric and normalized).*"

if HAS_GYM:
    import gymnasium
    import numpy
    from gymnasium import spaces
    from gymnasium.utils.env_checker import check_env
    from pettingzoo.test import parallel_api_test
    from reve.gym import Environment, Task
    from reve.gym.parallel import ParallelEnvironment

    sys.path.insert(0, str(PACKAGE / "examples"))
    from balance import Balance

    class Reach(Task):
        """Roll to the red ball; smaller distances give larger rewards."""

        observation_space = spaces.Box(-numpy.inf, numpy.inf, (3,), numpy.float64)
        action_space = spaces.Box(-1.0, 1.0, (2,), numpy.float32)

        def __init__(self, body):
            self.body = body

        def observe(self, perception):
            red, me = perception.find("red"), perception.find(self.body)
            position = numpy.array(me.location)
            return numpy.zeros(3) if red is None else numpy.array(red.location) - position

        def act(self, action):
            force = [100 * float(action[0]), 0.0, 100 * float(action[1])]
            return [reve.Act(None, "roll", {"force": force})]

        def reward(self, perception):
            return -float(numpy.linalg.norm(self.observe(perception)))

        def is_over(self, perception):
            return perception.time > 0.5 and self.body == "robot1"


def served(world):
    return reve.serve(ROOT / "worlds" / world, launcher=LAUNCHER)


@unittest.skipUnless(HAS_GYM, "the extra gym is not installed")
@pytest.mark.slow
class GymTest(unittest.TestCase):
    def environment(self, world, make):
        server = served(world)
        address = server.__enter__()
        self.addCleanup(server.__exit__, None, None, None)
        environment = make(address)
        self.addCleanup(environment.close)
        return environment

    def test_gymnasiums_checker_is_content(self):
        environment = self.environment(
            "cart-pole", lambda at: Environment(at, Balance(), frames=2, steps=50)
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=EXPECTED_WARNINGS)
            check_env(environment)

    def test_pettingzoos_checker_is_content(self):
        tasks = {"ada": Reach("robot1"), "bob": Reach("robot2")}
        environment = self.environment(
            "playground", lambda at: ParallelEnvironment(at, tasks, frames=3, steps=25)
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            parallel_api_test(environment, num_cycles=40)

    def test_gymnasiums_checker_is_content_with_what_is_rendered(self):
        environment = self.environment(
            "cart-pole",
            lambda at: Environment(
                at, Balance(), frames=2, steps=50, render_mode="rgb_array", camera=("viewer", "eye")
            ),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=EXPECTED_WARNINGS)
            check_env(environment)

    def test_a_rendered_picture_shows_the_world_as_the_step_left_it(self):
        environment = self.environment(
            "cart-pole",
            lambda at: Environment(
                at, Balance(), render_mode="rgb_array", camera=("viewer", "eye")
            ),
        )
        self.assertEqual(environment.metadata["render_fps"], 60)
        environment.reset(seed=1)
        before = environment.render()
        self.assertEqual((before.shape, before.dtype), ((160, 240, 3), numpy.uint8))
        red, _, blue = numpy.moveaxis(before.astype(int), 2, 0)
        cart, tip = numpy.argwhere(blue > red + 60), numpy.argwhere(red > blue + 60)
        self.assertLess(tip[:, 0].mean(), cart[:, 0].min())  # the tip is above the cart
        self.assertAlmostEqual(cart[:, 1].mean(), 119.5, delta=12)  # at the middle of the picture
        numpy.testing.assert_array_equal(environment.render(), before)  # the world stands still
        for _ in range(30):
            environment.step(numpy.array([1.0], numpy.float32))
        after = environment.render().astype(int)
        moved = numpy.argwhere(after[:, :, 2] > after[:, :, 0] + 60)
        self.assertGreater(abs(moved[:, 1].mean() - cart[:, 1].mean()), 20)

    def test_a_mode_without_a_camera_is_refused(self):
        with self.assertRaisesRegex(ValueError, "camera"):
            Environment(("127.0.0.1", 1), Balance(), render_mode="rgb_array")

    def test_the_same_seed_and_actions_make_the_same_episode_to_the_bit(self):
        environment = self.environment("cart-pole", lambda at: Environment(at, Balance()))

        def episode(seed):
            first, _ = environment.reset(seed=seed)
            push = numpy.array([0.3], numpy.float32)
            return [first, *(environment.step(push)[0] for _ in range(20))]

        one, other, again = episode(1), episode(2), episode(1)
        numpy.testing.assert_array_equal(one, again)
        self.assertFalse(numpy.array_equal(one, other))

    def test_a_push_moves_the_cart_as_newton_says(self):
        environment = self.environment("cart-pole", lambda at: Environment(at, Balance()))
        (_, before, _, _), _ = environment.reset(seed=3)
        (_, after, _, _), _, _, _, _ = environment.step(numpy.array([1.0], numpy.float32))
        # A force of 10 N acts for a frame on the cart of 1 kg. The tolerance allows for the pole.
        self.assertAlmostEqual(after - before, 10.0 / 60 / 1.0, delta=0.005)

    def test_an_edit_that_the_world_refuses_is_told(self):
        class Wrong(Balance):
            def begin(self, random):
                return [("tip", "physics.nothing", 1.0)]

        environment = self.environment("cart-pole", lambda at: Environment(at, Wrong()))
        with self.assertRaisesRegex(reve.ReveError, "physics.nothing of tip"):
            environment.reset(seed=1)

    def test_a_step_before_the_first_reset_is_refused(self):
        environment = self.environment("cart-pole", lambda at: Environment(at, Balance()))
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "reset"):
            environment.step(numpy.array([0.0], numpy.float32))
        environment.reset(seed=1)
        environment.step(numpy.array([0.0], numpy.float32))

    def test_each_world_of_a_server_has_an_environment_of_its_own(self):
        worlds = ROOT / "worlds"
        with reve.serve(worlds / "cart-pole", str(worlds / "playground"), launcher=LAUNCHER) as at:
            one = Environment(at, Balance(), world="cart-pole")
            self.addCleanup(one.close)
            other = Environment(at, Reach("robot1"), world="playground")
            self.addCleanup(other.close)
            one.reset(seed=1)
            other.reset(seed=1)
            for environment in (one, other, other, one):
                environment.step(environment.action_space.sample())
            with self.assertRaisesRegex(reve.ReveError, "has an environment of learner already"):
                Environment(at, Balance(), world="cart-pole")

    def test_a_server_ends_if_the_program_that_started_it_is_killed(self):
        program = (
            "import reve, sys, time\n"
            f"with reve.serve({str(ROOT / 'worlds' / 'cart-pole')!r}, launcher={str(LAUNCHER)!r})"
            " as at:\n"
            "    print(at[1], flush=True)\n"
            "    time.sleep(600)\n"
        )
        with subprocess.Popen(
            [sys.executable, "-c", program],
            stdout=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
        ) as killed:
            port = int(killed.stdout.readline())
            reve.connect("127.0.0.1", port, name="eye").close()
            killed.kill()
        end = time.monotonic() + PATIENCE
        while True:
            try:
                socket.create_connection(("127.0.0.1", port), timeout=PATIENCE).close()
            except ConnectionRefusedError:
                break
            self.assertLess(time.monotonic(), end, "the server still answers")
            time.sleep(0.1)

    def test_a_server_that_does_not_start_says_why(self):
        with self.assertRaisesRegex(reve.ReveError, "no-such-world"):
            with served("no-such-world"):
                pass

    def test_a_launcher_that_is_not_there_is_named(self):
        message = r"cannot run /nowhere/reve: No such file.*launcher"
        with self.assertRaisesRegex(reve.ReveError, message):
            with reve.serve("worlds/cart-pole", launcher="/nowhere/reve"):
                pass

    def test_the_learner_gets_better(self):
        run = subprocess.run(
            [
                sys.executable,
                str(PACKAGE / "examples" / "balance.py"),
                "--generations",
                "3",
                "--launcher",
                str(LAUNCHER),
            ],
            cwd=ROOT,
            env=ENVIRONMENT,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        self.assertIn(run.returncode, (0, 1), run.stderr)  # 1: the task is not solved yet
        history = json.loads(run.stdout)["history"]
        self.assertGreater(max(history[1:]), 2 * history[0], run.stderr)

    def test_the_example_of_the_page_runs(self):
        page = (ROOT / "docs" / "learning.md").read_text("utf-8")
        for script in re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
            run = subprocess.run(
                [sys.executable, "-c", script],
                cwd=ROOT,
                env=ENVIRONMENT,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertIn("points", run.stdout)


if __name__ == "__main__":
    unittest.main()
