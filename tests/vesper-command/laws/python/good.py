# SPDX-License-Identifier: Apache-2.0
# Laws that keep every promise: a spring to the origin with memory, and an integrator.
import numpy
import vesper


@vesper.law(phase="force", claims="rotation")
def good(
    position: vesper.Read("body", "m"),
    mass: vesper.Read("body", "kg"),
    force: vesper.Accumulate("body", "N"),
    pulls: vesper.Scratch("body", "N", components=3),
    rate: vesper.Parameter("1/s^2", default=2, least=0, most=10, doc="Pull for each kilogram"),
):
    "Pull to the origin by the place of the step before."
    force += pulls
    pulls[:] = -rate * mass[:, None] * position


@vesper.law(phase="integrate")
def good_motion(
    position: vesper.ReadWrite("body", "m"),
    velocity: vesper.ReadWrite("body", "m/s"),
    acceleration: vesper.Write("body", "m/s^2"),
    mass: vesper.Read("body", "kg"),
    externalForce: vesper.Read("body", "N"),
    dt,
):
    "Symplectic Euler; bodies of mass 0 do not move."
    moves = (mass != 0)[:, None]
    acceleration[:] = externalForce / numpy.where(moves, mass[:, None], 1) * moves
    velocity += acceleration * dt
    position += velocity * dt * moves
