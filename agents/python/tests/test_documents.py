"""The examples in the documents, run as they are against the real server; only the port is exchanged."""

import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import unittest
from typing import List

from support import PACKAGE, java, pond

DOCUMENTS = [PACKAGE / "README.md", PACKAGE.parents[1] / "docs" / "agents.md"]


def examples(document: pathlib.Path, language: str, port: int) -> List[str]:
    """The code blocks in that language, "" for those that name none."""
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", document.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    return [code.replace("7777", str(port)) for name, code in blocks if name == language]


class DocumentsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = pond()
        cls.port = cls.server.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__(None, None, None)

    def test_the_python_examples_run(self):
        scripts = [(d.name, script) for d in DOCUMENTS for script in examples(d, "python", self.port)]
        for document, script in scripts:
            with self.subTest(document=document, script=script):
                run = subprocess.run(
                    [sys.executable, "-c", script],
                    env={**os.environ, "PYTHONPATH": str(PACKAGE)}, capture_output=True, text=True, timeout=60,
                )
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertRegex(run.stdout, "duck|accepted=True")
                self.assertNotRegex(run.stdout, "refused|accepted=False")

    def test_the_java_examples_run(self):
        for example in examples(DOCUMENTS[1], "java", self.port):
            with self.subTest(example=example), tempfile.TemporaryDirectory() as folder:
                source = pathlib.Path(folder, "Example.java")
                source.write_text(example, "utf-8")
                run = subprocess.run(java(str(source)), capture_output=True, text=True, timeout=60)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertIn("duck painted", run.stdout)
                self.assertNotIn("false", run.stdout)

    def test_the_lines_typed_by_hand_are_answered_as_described(self):
        lines = examples(DOCUMENTS[1], "", self.port)[0]
        expected = {"hello": "welcome", "perceive": "perception", "act": "result", "bye": "bye"}
        with socket.create_connection(("127.0.0.1", self.port), timeout=20) as connection:
            answers = connection.makefile("r", encoding="utf-8")
            for line in lines.splitlines():
                connection.sendall(line.encode() + b"\n")
                wanted = expected[re.search(r'"t":"(\w+)"', line).group(1)]
                answer = answers.readline()
                while '"t":"event"' in answer:
                    answer = answers.readline()
                self.assertIn(f'"t":"{wanted}"', answer)
            self.assertEqual(answers.readline(), "")


if __name__ == "__main__":
    unittest.main()
