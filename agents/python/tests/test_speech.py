# SPDX-License-Identifier: Apache-2.0
"""Tests of two agents that speak and hear, with the example meet.py and real servers."""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from reve import connect
from support import ENVIRONMENT, PACKAGE, PATIENCE, java, launched, pond

ROOT = PACKAGE.parents[1]
EXAMPLES = PACKAGE / "examples"

EXPERIMENT = f"""
experiment: 1
name: meeting
world: meet.yaml
seconds: 4
agents:
  caller: {{command: ["{sys.executable}", "{EXAMPLES / "meet.py"}", caller]}}
  seeker: {{command: ["{sys.executable}", "{EXAMPLES / "meet.py"}", seeker]}}
every: 1
measures:
  x: {{of: seeker, is: "physical.location[0]"}}
  z: {{of: seeker, is: "physical.location[2]"}}
"""


LOST = "\\u2026"  # a lost word, as meet.py prints it


def some_of(text):
    """Returns the pattern of a printed text in which each word may be lost."""
    return '"' + " ".join(f"({word}|{re.escape(LOST)})" for word in text.split(" ")) + '"'


def reve(*arguments, cwd=ROOT):
    return subprocess.run(
        [str(ROOT / "reve"), *arguments],
        cwd=cwd,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


JAVA = """
import reve.agent.AgentClient;
import reve.agent.Heard;

void main(String[] arguments) throws Exception {
    int port = Integer.parseInt(arguments[0]);
    try (AgentClient agent = AgentClient.connect("127.0.0.1", port, "duke")) {
        IO.println("accepted: " + agent.say("hello from Java").accepted());
        while (true) {
            for (Heard heard : agent.perceive().heard()) {
                IO.println(heard.speaker().orElseThrow() + " says " + heard.text());
                return;
            }
        }
    }
}
"""


class ClientsTest(unittest.TestCase):
    def test_agents_in_python_and_java_hear_each_other(self):
        with pond() as port, tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder, "Duke.java")
            source.write_text(JAVA, "utf-8")
            with connect(port=port, name="ann") as ann:
                duke = subprocess.Popen(
                    java(str(source), str(port)), stdout=subprocess.PIPE, text=True
                )
                voices = []
                for perception in ann.perceptions(every=2):
                    voices += perception.heard
                    if voices or duke.poll() is not None:
                        break
                self.assertEqual([voice.text for voice in voices], ["hello from Java"])
                self.assertEqual(voices[0].speaker, "duke")
                self.assertTrue(ann.say("hello from Python"))
                out, _ = duke.communicate(timeout=PATIENCE)
                self.assertEqual(
                    out.splitlines(),
                    ["accepted: true", f"{ann.body} says hello from Python"],
                )


class MeetingTest(unittest.TestCase):
    def test_two_agents_meet_by_their_voices_and_the_recording_is_replayed_to_the_bit(self):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder, "meet.log")
            world = str(EXAMPLES / "meet.yaml")
            # The world waits for its agents as long as meet.py asks for.
            options = ("--port", "0", "--deadline", "60", "--waiting", "off", "--record", str(log))
            with launched("serve", world, *options) as port:
                agents = [
                    subprocess.Popen(
                        [sys.executable, str(EXAMPLES / "meet.py"), role, "--port", str(port)],
                        env=ENVIRONMENT,
                        stdout=subprocess.PIPE,
                        stderr=subprocess.PIPE,
                        text=True,
                    )
                    for role in ("caller", "seeker")
                ]
                (caller, _), (seeker, problems) = [
                    agent.communicate(timeout=PATIENCE) for agent in agents
                ]
            self.assertEqual(json.loads(seeker.splitlines()[-1])["met"], True, seeker + problems)
            self.assertEqual(json.loads(caller.splitlines()[-1])["met"], True, caller)
            self.assertRegex(caller, " m a voice " + some_of("I have found you, caller"))
            first, *_ = seeker.splitlines()
            self.assertRegex(
                first, r"^\d+ 13\.00 m a voice " + some_of(r"here I am, call number \d+")
            )
            self.assertIn(LOST, seeker, "words are lost")
            self.assertIn(" m caller ", seeker, "an agent that is touched has a name")
            replayed = reve("replay", str(log))
            self.assertEqual(replayed.returncode, 0, replayed.stdout + replayed.stderr)
            self.assertRegex(replayed.stdout, r"^identical: \d+ frames")

    def test_a_repetition_hears_the_same_words_in_the_same_frames(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "meeting.yaml").write_text(EXPERIMENT, "utf-8")
            shutil.copy(EXAMPLES / "meet.yaml", folder)
            logs = []
            for repetition in ("one", "two"):
                run = reve("experiment", "meeting.yaml", "--out", repetition, "--trust", cwd=folder)
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
                written = {
                    path.name: path.read_text("utf-8")
                    for path in sorted(pathlib.Path(folder, repetition, "agents").iterdir())
                }
                self.assertEqual(len(written), 2)
                logs.append(written)
            self.assertEqual(logs[0], logs[1])
            seeker = next(text for name, text in logs[0].items() if "seeker" in name)
            self.assertGreater(seeker.count(LOST), 10)


if __name__ == "__main__":
    unittest.main()
