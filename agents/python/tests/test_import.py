# SPDX-License-Identifier: Apache-2.0
"""Robots that `reve import` made, against MuJoCo, which reads the same files."""

import math
import pathlib
import re
import subprocess
import tempfile
import unittest

import mujoco
import numpy
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
_SWING = """<mujoco model="swing">
  <compiler eulerseq="xYz"/>
  <option gravity="0 0.5 -9.7" timestep="0.0005"/>
  <default>
    <geom density="800"/>
    <default class="arm">
      <geom type="capsule" size="0.03"/><joint axis="0 1 0.2"/>
      <default class="hand"><geom type="box" density="500"/></default>
    </default>
  </default>
  <worldbody>
    <body name="upper" pos="0.1 0.2 1.2" euler="10 20 30" childclass="arm">
      <joint name="shoulder"/>
      <geom fromto="0 0 0 0.35 0.02 0"/>
      <frame pos="0.4 0 0" axisangle="1 0 0 8">
        <body name="fore">
          <joint name="elbow" pos="-0.02 0.01 0"/>
          <inertial pos="0.15 0.01 0" euler="12 6 -17" mass="1.2"
            diaginertia="0.001 0.01 0.0105"/>
          <body name="hand" pos="0.3 0 0" zaxis="0.1 0.2 1" childclass="hand">
            <joint name="wrist" axis="0 0 1"/>
            <geom pos="0.06 0 0.02" size="0.06 0.03 0.02" xyaxes="1 0.2 0 0 1 0.3"/>
            <body name="tool" pos="0.12 0 0"><geom type="sphere" size="0.02" mass="0.1"/></body>
          </body>
        </body>
      </frame>
    </body>
  </worldbody>
</mujoco>
"""
_ZOO = """<mujoco model="zoo">
  <compiler angle="radian" eulerseq="ZYX"/>
  <default class="main"><geom density="700"/></default>
  <default><default class="rod"><geom type="cylinder" size="0.02 0.1"/></default></default>
  <worldbody>
    <geom type="plane" size="0 0 0.1" pos="0 0 -1"/>
    <body name="trunk" pos="0.1 0.2 0.9" euler="0.3 -0.5 0.7">
      <freejoint/>
      <geom type="box" size="0.2 0.1 0.05" euler="0 0.4 0.15"/>
      <geom type="ellipsoid" size="0.05 0.06 0.07" pos="0 0.02 0.1" quat="1 1 0 0.5" mass="0.3"/>
      <body name="leg" pos="0.15 0.1 0" childclass="rod">
        <joint type="hinge" pos="0.01 0 0.02"/>
        <geom fromto="0 0 0 0.1 0 -0.2"/><geom zaxis="1 1 0" pos="0.1 0 -0.2" mass="0.4"/>
        <body name="foot" pos="0.1 0 -0.2" quat="0.9 0.1 0.2 0.3">
          <joint type="ball"/>
          <geom type="mesh" mesh="wedge" pos="0 0 -0.1" euler="0.1 0.2 0.3"/>
        </body>
      </body>
      <body name="tail" pos="-0.2 0 0" xyaxes="0 1 0 -1 0 0.2"><joint type="slide"/>
        <inertial pos="0 0.1 0" mass="0.2"
          fullinertia="0.002 0.003 0.004 0.0001 0.0002 -0.0003"/>
        <geom size="0.5"/>
      </body>
    </body>
    <body name="ball" pos="3 0 0"><freejoint/><geom size="0.2"/></body>
  </worldbody>
  <asset><mesh name="wedge" file="wedge.obj" scale="0.3 0.2 -0.1"/></asset>
</mujoco>
"""
_WEDGE = """v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.1 1
f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"""
# The same arms with damping, springs and rotors in their joints.
_DAMPED_ARM = re.sub(
    r'(<axis xyz="0 1 0[^>]*>)', r'\1<dynamics damping="0.4"/>', _ARM.replace("arm", "damped")
)
_DAMPED_SWING = _SWING.replace(
    '<joint name="shoulder"/>', '<joint name="shoulder" damping="0.3" armature="0.2"/>'
).replace(
    '<joint name="elbow" pos',
    '<joint name="elbow" stiffness="4" springref="30" damping="0.2" armature="0.05" pos',
)
# The first arm with a gear between two of its joints, which MuJoCo keeps almost rigid.
_GEARED_SWING = _SWING.replace(
    "</worldbody>",
    """</worldbody>
  <equality>
    <joint joint1="wrist" joint2="elbow" polycoef="0 -1.5 0 0 0" solref="0.0003 1"
      solimp="0.9999 0.9999 0.001 0.5 2"/>
  </equality>""",
)
# The first arm with actuators of its joints, which brake them because their controls are 0.
_BRAKED_SWING = _SWING.replace(
    "</worldbody>",
    """</worldbody>
  <actuator>
    <velocity joint="elbow" kv="0.2" gear="1.5"/>
    <general joint="shoulder" gainprm="0.3" biastype="affine" biasprm="0 0 -0.3"/>
  </actuator>""",
)
_RATE = 9600  # steps of MuJoCo per second
_UP = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # from axes with +Z up


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
    moving = [i for i in range(1, model.nbody) if model.body_weldid[i] == i]
    return {model.body(i).name: tuple(subtree_inertia(model, data, i)[1]) for i in moving}


def rotation(q):
    """Returns the matrix of a unit quaternion xyzw."""
    flat = numpy.zeros(9)
    mujoco.mju_quat2Mat(flat, numpy.array([q[3], q[0], q[1], q[2]]))
    return flat.reshape(3, 3)


def bodies_of_world(folder):
    """Returns mass, location and inertia in the axes of the world of each body that moves."""
    text = re.sub(r"\s+", " ", (folder / "robot.yaml").read_text("utf-8"))
    bodies = {}
    for item in text.split("- name: ")[1:]:
        mass = re.search(r"mass: ([^,}]*)", item)
        if mass is None or float(mass[1]) == 0:
            continue

        def numbers(key, otherwise, item=item):
            found = re.search(rf"\b{key}: \[([^\]]*)\]", item)
            return numpy.array([float(x) for x in found[1].split(",")] if found else otherwise)

        axes = rotation(numbers("orientation", [0, 0, 0, 1]))
        inertia = axes @ numpy.diag(numbers("inertia", [0, 0, 0])) @ axes.T
        bodies[item.split(" physical:")[0]] = (float(mass[1]), numbers("location", None), inertia)
    return bodies


def subtree_inertia(model, data, i):
    """Returns mass, location and inertia of a body with the bodies welded to it, from MuJoCo."""
    parts = [j for j in range(1, model.nbody) if model.body_weldid[j] == i]
    mass = sum(model.body_mass[j] for j in parts)
    centre = sum(model.body_mass[j] * data.xipos[j] for j in parts) / mass
    inertia = numpy.zeros((3, 3))
    for j in parts:
        axes = data.ximat[j].reshape(3, 3)
        away = data.xipos[j] - centre
        inertia += axes @ numpy.diag(model.body_inertia[j]) @ axes.T
        inertia += model.body_mass[j] * (away @ away * numpy.eye(3) - numpy.outer(away, away))
    return mass, _UP @ centre, _UP @ inertia @ _UP.T


def imported(folder, name, text):
    """Imports a file and returns its path and the folder of the world."""
    file = folder / name
    file.write_text(text, "utf-8")
    out = folder / "world"
    subprocess.run([LAUNCHER, "import", file, "--out", out], check=True, cwd=ROOT)
    return file, out


@pytest.mark.slow
class ImportTest(unittest.TestCase):
    def test_bodies_have_the_masses_places_and_inertia_of_mujoco(self):
        for text in (_SWING, _ZOO):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                (folder / "wedge.obj").write_text(_WEDGE, "utf-8")
                file, out = imported(folder, "robot.xml", text)
                model = mujoco.MjModel.from_xml_path(str(file))
                data = mujoco.MjData(model)
                mujoco.mj_forward(model, data)
                bodies = bodies_of_world(out)
                moving = [i for i in range(1, model.nbody) if model.body_weldid[i] == i]
                self.assertEqual(sorted(bodies), sorted(model.body(i).name for i in moving))
                for i in moving:
                    called = model.body(i).name
                    mass, place, inertia = subtree_inertia(model, data, i)
                    self.assertAlmostEqual(bodies[called][0], mass, delta=1e-6 * mass, msg=called)
                    self.assertLess(math.dist(bodies[called][1], place), 1e-7, called)
                    error = abs(bodies[called][2] - inertia).max()
                    self.assertLess(error, 1e-5 * abs(inertia).max(), called)

    def test_a_swinging_arm_moves_as_in_mujoco(self):
        self.assertEqual(_DAMPED_ARM.count("damping"), 2)
        for file_name, text in (
            ("arm.urdf", _ARM),
            ("arm.xml", _SWING),
            ("damped.urdf", _DAMPED_ARM),
            ("damped.xml", _DAMPED_SWING),
            ("geared.xml", _GEARED_SWING),
            ("braked.xml", _BRAKED_SWING),
        ):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                file, out = imported(folder, file_name, text)
                world = out / "world.yaml"
                text = re.sub(r"steps: \d+", "steps: 128", world.read_text("utf-8"))
                world.write_text(text, "utf-8")
                for seconds in (0.5, 1.0, 2.0) if file_name == "arm.urdf" else (2.0,):
                    saved = folder / "saved.yaml"
                    subprocess.run(
                        [LAUNCHER, "run", out, "--seconds", str(seconds), "--save", saved],
                        check=True,
                        cwd=ROOT,
                        capture_output=True,
                    )
                    places = centres_of_mujoco(file, seconds)
                    for body, place in places.items():
                        found = re.search(
                            rf"- name: {body}\n\s+physical: \{{location: \[([^\]]*)\]",
                            saved.read_text("utf-8"),
                        )
                        numbers = [float(number) for number in found[1].split(",")]
                        self.assertLess(math.dist(numbers, place), 1e-3, f"{body} at {seconds} s")


if __name__ == "__main__":
    unittest.main()
