# SPDX-License-Identifier: Apache-2.0
"""Robots that `reve import` made, against MuJoCo, which reads the same URDF files."""

import math
import pathlib
import re
import subprocess
import tempfile
import unittest

import mujoco
import pytest
from support import PACKAGE

ROOT = PACKAGE.parents[1]
LAUNCHER = ROOT / "reve"

_ARM = """<robot name="arm">
  <link name="world"/>
  <link name="upper">
    <inertial><origin xyz="0.2 0 0"/><mass value="2"/>
      <inertia ixx="0.002" iyy="0.03" izz="0.031" ixy="0.001" ixz="0" iyz="0.0005"/></inertial>
  </link>
  <link name="fore">
    <inertial><origin xyz="0.15 0.01 0" rpy="0.2 0.1 -0.3"/><mass value="1.2"/>
      <inertia ixx="0.001" iyy="0.01" izz="0.0105" ixy="0" ixz="0.0002" iyz="0"/></inertial>
  </link>
  <link name="hand">
    <inertial><origin xyz="0.05 0 0.02"/><mass value="0.4"/>
      <inertia ixx="0.0004" iyy="0.0008" izz="0.0009" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="tool">
    <inertial><origin xyz="0 0 0"/><mass value="0.1"/>
      <inertia ixx="0.0001" iyy="0.0001" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="shoulder" type="continuous"><origin xyz="0 0 1.2" rpy="0 0 0.3"/>
    <parent link="world"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><origin xyz="0.4 0 0" rpy="0.1 0 0"/>
    <parent link="upper"/><child link="fore"/><axis xyz="0 1 0.2"/></joint>
  <joint name="wrist" type="continuous"><origin xyz="0.3 0 0" rpy="0 0.5 0"/>
    <parent link="fore"/><child link="hand"/><axis xyz="0 0 1"/></joint>
  <joint name="grip" type="fixed"><origin xyz="0.1 0 0"/>
    <parent link="hand"/><child link="tool"/></joint>
</robot>
"""
_RATE = 9600  # steps of MuJoCo per second


def centres_of_mujoco(file, seconds):
    """Returns the centres of mass of the bodies by name, in axes with +Y up."""
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = 1 / _RATE
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    for _ in range(round(seconds * _RATE)):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    places = {}
    for i in range(1, model.nbody):
        x, y, z = data.xipos[i]
        places[model.body(i).name] = (x, z, -y)
    return places


@pytest.mark.slow
class ImportTest(unittest.TestCase):
    def test_a_swinging_arm_moves_as_in_mujoco(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            urdf = folder / "arm.urdf"
            urdf.write_text(_ARM, "utf-8")
            subprocess.run(
                [LAUNCHER, "import", urdf, "--out", folder / "arm"], check=True, cwd=ROOT
            )
            world = folder / "arm" / "world.yaml"
            text = world.read_text("utf-8")
            world.write_text(text.replace("steps: 16", "steps: 128"), "utf-8")
            for seconds in (0.5, 1.0, 2.0):
                saved = folder / "saved.yaml"
                subprocess.run(
                    [LAUNCHER, "run", folder / "arm", "--seconds", str(seconds), "--save", saved],
                    check=True,
                    cwd=ROOT,
                    capture_output=True,
                )
                for body, place in centres_of_mujoco(urdf, seconds).items():
                    found = re.search(
                        rf"- name: {body}\n\s+physical: \{{location: \[([^\]]*)\]",
                        saved.read_text("utf-8"),
                    )
                    numbers = [float(number) for number in found[1].split(",")]
                    self.assertLess(math.dist(numbers, place), 1e-3, f"{body} at {seconds} s")


if __name__ == "__main__":
    unittest.main()
