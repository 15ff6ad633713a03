// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.worlds.journal.Journal;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * No value that an agent can choose for an action causes the loss of a law for the other agents.
 */
class HostileActsNativeTest {
    private static final int FRAMES = 60;
    private static final int WHEN = 2;

    /** Properties of an item that actions set to their argument, with their units. */
    private static final Map<String, String> SCALARS =
            Map.of(
                    "mass",
                    "kg",
                    "charge",
                    "C",
                    "radius",
                    "m",
                    "dragCoefficient",
                    "kg/m",
                    "linearDragCoefficient",
                    "kg/s");

    private static final Map<String, String> VECTORS =
            Map.of(
                    "velocity",
                    "m/s",
                    "angularVelocity",
                    "rad/s",
                    "inertia",
                    "kg*m^2",
                    "appliedForce",
                    "N",
                    "torque",
                    "N*m");
    private static final Map<String, String> OTHERS =
            Map.of("place", "m", "push", "N", "kick", "N*s");
    private static final double[] TAKEN = {1e-100, 1e-50, 1e30, 1e50, 1e100, -1e100, 0};
    private static final double[] REFUSED = {1e-320, 5e-324, 1e-160, -1e-101, 1.1e100};

    @TempDir private Path folder;

    /**
     * Returns a world of bodies with these laws. For each action it also has a body with a name
     * that begins with evil.
     */
    private static WorldDescription world(String laws, String... evil) throws WorldFileException {
        var text =
                new StringBuilder(
                        """
                        reve: 1
                        name: w
                        frame: {rate: 60, steps: 4}
                        laws: [%s]
                        constants: {gravity: [0, -9.81, 0], gravitationalConstant: 6.7e-11,
                          coulombConstant: 9e9, electricField: [0, 1, 0], magneticField: [0, 0, 1]}
                        prefabs:
                          ball:
                            physical: {shape: sphere, radius: 0.5}
                            physics: {mass: 1, charge: 1e-6, radius: 0.5, inertia: [0.1, 0.1, 0.1],
                              dragCoefficient: 0.1, linearDragCoefficient: 0.1}
                        items:
                          - {name: first, like: ball, physical: {location: [0, 0, 0]}}
                        """
                                .formatted(laws));
        for (int i = 0; i < evil.length; i++) {
            String name = "evil-" + evil[i];
            text.append(
                    """
                      - name: %s
                        like: ball
                        physical: {location: [%s, 0, 0]}
                        sensors: {imu: {imu: {}}}
                        access: {%s: %s}
                    """
                            .formatted(name, 0.9 * (i + 1), evil[i], action(evil[i])));
            text.append("  - {name: spring-")
                    .append(name)
                    .append(", kind: spring, physics: {")
                    .append("springConstant: 10, length: 1, end1: first, end2: ")
                    .append(name)
                    .append("}}\n");
        }
        text.append(
                "  - {name: last, like: ball, physical: {location: [0, 5, 3]},"
                        + " physics: {velocity: [1, 0, 0]}}\n");
        return WorldFile.parse("w", text.toString().getBytes(StandardCharsets.UTF_8));
    }

    private static String action(String name) {
        boolean scalar = SCALARS.containsKey(name);
        String unit = scalar ? SCALARS.get(name) : VECTORS.getOrDefault(name, OTHERS.get(name));
        String effect =
                switch (name) {
                    case "push" -> "force: $to, for: 1 s";
                    case "kick" -> "impulse: $to";
                    case "place" -> "set: physical.location, to: $to";
                    default -> "set: physics." + name + ", to: $to";
                };
        return "{parameters: {to: {"
                + (scalar ? "" : "components: 3, ")
                + "unit: "
                + unit
                + "}}, effects: [{"
                + effect
                + "}]}";
    }

    private static String[] all() {
        var all = new ArrayList<>(SCALARS.keySet());
        all.addAll(VECTORS.keySet());
        all.addAll(OTHERS.keySet());
        return all.stream().sorted().toArray(String[]::new);
    }

    private static void act(World world, String name, double value) throws ActionRefused {
        Item evil = world.find("evil-" + name).orElseThrow();
        Action action = evil.access().find(name).orElseThrow();
        Object given = SCALARS.containsKey(name) ? value : List.of(value, value, value);
        new ActionCall(
                        world,
                        WHEN,
                        evil,
                        Optional.of(evil),
                        Arguments.check(action, Map.of("to", given)))
                .perform(action);
    }

    /** Returns the faults of a run in which agents act with a value in one frame. */
    private static List<WorldEvent> run(Simulation simulation, double value, String... actions) {
        var faults = new ArrayList<WorldEvent>();
        simulation
                .bus()
                .subscribe(
                        FramePhase.PUBLISH,
                        "faults",
                        event ->
                                event.world().events().stream()
                                        .filter(happened -> happened.type().equals("fault"))
                                        .forEach(faults::add));
        simulation.loop().run(WHEN - 1);
        for (String action : actions) {
            try {
                act(simulation.world(), action, value);
            } catch (ActionRefused refused) {
                assertThat(refused.code()).isIn("out-of-range", "immovable");
            }
        }
        simulation.loop().run(FRAMES);
        return faults;
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "newton_motion",
                "velocity_verlet",
                "runge_kutta4",
                "angular_motion",
                "drag, newton_motion",
                "gravity_field, newton_motion",
                "hooke_spring, newton_motion",
                "hooke_spring, runge_kutta4",
                "coulomb, newton_motion",
                "lorentz_field, newton_motion",
                "newton_gravitation, velocity_verlet",
                "barnes_hut_gravitation, newton_motion",
                "sphere_contact, newton_motion, angular_motion"
            })
    void noShippedLawIsLostWhateverAgentsSet(String laws) throws WorldFileException {
        for (double value : TAKEN) {
            try (var simulation = new Simulation(world(laws, all()), Pacing.FAST)) {
                List<WorldEvent> faults = run(simulation, value, all());
                assertThat(simulation.physics().laws().quarantined())
                        .as("%s with %s: %s", laws, value, faults)
                        .isEmpty();
                assertThat(faults)
                        .allSatisfy(
                                fault ->
                                        assertThat(fault.fields()).containsEntry("arrested", true));
            }
        }
    }

    /** The numbers of the item are already 0, except those of its place. */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "hooke_spring, newton_motion",
                "coulomb, newton_motion",
                "newton_gravitation, velocity_verlet",
                "sphere_contact, newton_motion, angular_motion"
            })
    void anArrestedItemThatItsAgentMovesAgainCostsNoLaw(String laws) throws Exception {
        try (var simulation = new Simulation(world(laws, "place"), Pacing.FAST)) {
            List<WorldEvent> faults = run(simulation, 1e100, "place");
            for (double value : new double[] {1e100, -1e100, 1e100}) {
                act(simulation.world(), "place", value);
                simulation.loop().run(3);
            }
            assertThat(simulation.physics().laws().quarantined()).as("%s", faults).isEmpty();
            assertThat(faults)
                    .hasSizeGreaterThanOrEqualTo(laws.startsWith("hooke") ? 4 : 0)
                    .allSatisfy(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("item", "evil-place")
                                            .containsEntry("arrested", true));
        }
    }

    @Test
    void magnitudesThatNoLawCanComputeWithAreRefused() throws WorldFileException {
        try (var simulation = new Simulation(world("newton_motion", all()), Pacing.FAST)) {
            for (String name : all()) {
                for (double value : REFUSED) {
                    assertThat(
                                    catchThrowableOfType(
                                                    ActionRefused.class,
                                                    () -> act(simulation.world(), name, value))
                                            .code())
                            .as("%s of %s", name, value)
                            .isEqualTo("out-of-range");
                }
            }
        }
    }

    @Test
    void theItemThatALawFailsAtIsArrestedAndNamedAndTheOthersGoOn() throws WorldFileException {
        try (var simulation =
                new Simulation(world("drag, newton_motion", "velocity"), Pacing.FAST)) {
            List<WorldEvent> faults = run(simulation, 1e100, "velocity");
            assertThat(faults)
                    .singleElement()
                    .satisfies(
                            fault -> {
                                assertThat(fault.fields())
                                        .containsEntry("library", "drag")
                                        .containsEntry("item", "evil-velocity")
                                        .containsEntry("arrested", true);
                                assertThat(fault.frame()).isEqualTo(WHEN);
                            });
            Item evil = simulation.world().find("evil-velocity").orElseThrow();
            assertThat(evil.physics().scalar("mass")).isZero();
            assertThat(evil.physics().vector("velocity")).containsOnly(0);
            assertThat(
                            simulation
                                    .world()
                                    .find("last")
                                    .orElseThrow()
                                    .physics()
                                    .vector("velocity")[0])
                    .as("slowed by drag")
                    .isBetween(0.5, 0.95);
        }
    }

    @Test
    void aRecordingWithAnArrestIsMadeAgainToTheBit() throws Exception {
        Path log = folder.resolve("run.log");
        WorldDescription description = world("drag, newton_motion", "velocity", "mass");
        long hash;
        try (var simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                })) {
            run(simulation, 1e100, "velocity", "mass");
            hash = simulation.physics().stateHash();
        }
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // the list stays open for further records
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
                assertThat(again.physics().laws().quarantined()).isEmpty();
            }
        }
    }
}
