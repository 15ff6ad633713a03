# SPDX-License-Identifier: Apache-2.0
"""Measures OpenMM's custom forces beside laws as text with the same formula, in turn, on one thread.

Arguments: the command of text_bench with its first two arguments, and the number of rounds. Prints
a table. The time of OpenMM is the time of a step with the force, minus the time of a step without
it.
"""

import statistics
import subprocess
import sys
import time

import openmm

GRAVITY = "-m*(gx*x + gy*y + gz*z)"
NEWTON = "-G*m1*m2/sqrt(r^2 + s^2)"


def external():
    force = openmm.CustomExternalForce(GRAVITY)
    for name, value in (("gx", 0.1), ("gy", -9.81), ("gz", 0)):
        force.addGlobalParameter(name, value)
    force.addPerParticleParameter("m")
    return force, lambda i: force.addParticle(i, [1 + i % 7 / 8])


def nonbonded():
    force = openmm.CustomNonbondedForce(NEWTON)
    force.setNonbondedMethod(openmm.CustomNonbondedForce.NoCutoff)
    for name, value in (("G", 1), ("s", 0.05)):
        force.addGlobalParameter(name, value)
    force.addPerParticleParameter("m")
    return force, lambda i: force.addParticle([1 + i % 7 / 8])


def context(rows, make):
    system = openmm.System()
    force, add = make() if make else (None, lambda i: None)
    places = []
    for i in range(rows):
        system.addParticle(1e30)  # so heavy that it stays where it is
        add(i)
        places.append(openmm.Vec3(i * 37 % 101 / 3, i * 61 % 103 / 3, i * 89 % 107 / 3))
    if force is not None:
        system.addForce(force)
    platform = openmm.Platform.getPlatformByName("CPU")
    world = openmm.Context(system, openmm.VerletIntegrator(1e-6), platform, {"Threads": "1"})
    world.setPositions(places)
    world.getIntegrator().step(2)
    return world


def step_time(world, steps):
    start = time.process_time()
    world.getIntegrator().step(steps)
    return (time.process_time() - start) / steps


def measure(name, law, make, rows, work, steps, text, rounds):
    with_force, without = context(rows, make), context(rows, None)
    ours = {"f64": [], "f32": []}
    theirs = []
    for _ in range(rounds):
        theirs.append((step_time(with_force, steps) - step_time(without, steps)) / work * 1e9)
        for precision, times in ours.items():
            command = [*text, "3", law, str(rows), precision]
            times.append(float(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout))
    other = statistics.median(theirs)
    for precision, times in ours.items():
        mine = statistics.median(times)
        print(
            f"| {law} | {rows} | {precision} | {name} | {mine:.2f} | {other:.2f} | "
            f"{other / mine:.2f} |"
        )


def main():
    *text, rounds = sys.argv[1:]
    print(f"OpenMM {openmm.version.version}, platform CPU\n")
    print("| law | rows | | beside | text [ns per row or pair] | other [ns] | times as fast |")
    print("|---|---:|---|---|---:|---:|---:|")
    rows = 100000
    measure("CustomExternalForce", "gravity_field", external, rows, rows, 10, text, int(rounds))
    for rows in (1536, 16384):
        pairs = rows * (rows - 1) / 2
        steps = 5 if rows < 2000 else 1
        measure(
            "CustomNonbondedForce",
            "newton_gravitation",
            nonbonded,
            rows,
            pairs,
            steps,
            text,
            int(rounds),
        )


if __name__ == "__main__":
    main()
