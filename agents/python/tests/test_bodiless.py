# SPDX-License-Identifier: Apache-2.0
"""An agent that removes its own body hinders no operator."""

import pathlib
import tempfile
import time
import unittest

import reve
from support import PATIENCE, launched

WORLD = """
reve: 1
name: pond
agents:
  body:
    physical: {shape: sphere, radius: 0.2}
    access: {die: {effects: [{remove: true}]}}
items:
  - {name: valve, physical: {shape: sphere, radius: 0.2, location: [50, 0, 0]}}
"""


class BodilessTest(unittest.TestCase):
    def test_edits_and_saving_go_on(self):
        with tempfile.TemporaryDirectory() as folder:
            world = pathlib.Path(folder, "pond.yaml")
            world.write_text(WORLD)
            with launched("serve", str(world), "--port", "0", "--saves", folder) as port:
                with reve.connect(port=port, name="ada") as ada, reve.control(port=port) as boss:
                    self.assertTrue(ada.act(str(ada.body), "die"))
                    self.assertTrue(
                        boss.batch(
                            {"t": "add", "items": [{"name": "tap"}]},
                            {"t": "remove", "item": "valve"},
                        )
                    )
                    saved = boss.save("later")
                    self.assertTrue(saved, saved)
                    self.wait_for(pathlib.Path(folder, "later.yaml"))

    def wait_for(self, file):
        end = time.monotonic() + PATIENCE
        while not file.exists():
            self.assertLess(time.monotonic(), end, f"no {file}")
            time.sleep(0.05)


if __name__ == "__main__":
    unittest.main()
