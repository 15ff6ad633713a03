// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.worlds.journal.SimulationImage;

import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;
import java.util.Set;

/** Laws as text that a world file contains, or that lie beside it. */
class LawTextNativeTest {
    private static final String ITEMS =
            """
            items:
              - {name: stone, physical: {shape: sphere, radius: 1 m}, physics: {mass: 2 kg}}
            """;
    private static final String INLINE =
            """
            reve: 1
            name: windy
            laws:
              - newton_motion
              - text: |
                  law push "A constant force."
                    parameter f = 1 N, from 0 N to 100 N
                    each body:
                      force += f (1, 0, 0)
                parameters: {f: 0.008 kN}
            """;

    @TempDir private Path folder;

    private WorldDescription world(String text) throws Exception {
        return WorldFile.load(Files.writeString(folder.resolve("world.yaml"), text + ITEMS));
    }

    private static double speed(Simulation simulation) {
        return simulation.world().find("stone").orElseThrow().physics().vector("velocity")[0];
    }

    @Test
    void aTextInTheWorldFileActsWithItsParameters() throws Exception {
        try (Simulation simulation = new Simulation(world(INLINE), Pacing.FAST)) {
            simulation.loop().run(60);
            assertThat(speed(simulation)).isCloseTo(4, within(1e-9));
        }
    }

    @Test
    void aWrongTextIsRefusedWithItsPlaceInTheFileAndInTheText() throws Exception {
        WorldDescription wrong =
                world(INLINE.replace("force += f (1, 0, 0)", "force += f velocity"));
        assertThatThrownBy(() -> new Simulation(wrong, Pacing.FAST).close())
                .isInstanceOf(PhysicsException.class)
                .message()
                .startsWith(folder + "/world.yaml:5:11: push.law:4:14: 'f velocity' is a vector in")
                .contains("but 'force' is N (a force)");
    }

    @Test
    void aParameterOfATextKeepsItsUnit() throws Exception {
        WorldDescription wrong = world(INLINE.replace("0.008 kN", "3 kg"));
        assertThatThrownBy(() -> new Simulation(wrong, Pacing.FAST).close())
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining("parameter f: unit kg");
    }

    @Test
    void aTextBesideTheWorldFileNeedsNoTrust() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Files.writeString(
                laws.resolve("push.law"), "law push\n  each body:\n    force += (8, 0, 0) N\n");
        WorldDescription named = world("reve: 1\nname: windy\nlaws: [newton_motion, push]\n");
        LawPath path = LawPath.ofShipped().forWorld(folder);
        assertThat(path.needsTrust("push")).isFalse();
        try (Simulation simulation = new Simulation(named, Pacing.FAST, path)) {
            simulation.loop().run(60);
            assertThat(speed(simulation)).isCloseTo(4, within(1e-9));
        }
        Files.write(laws.resolve("libvesper_law_push.so"), new byte[] {0x7f, 'E', 'L', 'F'});
        assertThatThrownBy(() -> path.find("push"))
                .hasMessageContaining("is there twice")
                .hasMessageContaining("push.law");
        assertThat(path.find("push.law").isText()).isTrue();
    }

    @Test
    void aShippedNameMeansTheCompiledLawUnlessItsEndingIsWritten() throws Exception {
        LawPath path = LawPath.ofShipped();
        assertThat(path.find("drag").file().toString()).endsWith("libvesper_law_drag.so");
        assertThat(path.find("drag.law").file().toString()).endsWith("/drag.law");
    }

    @Test
    void aSavedWorldContainsItsTextsAndContinuesToTheBit() throws Exception {
        double expected;
        Path saved = folder.resolve("saved.yaml");
        try (Simulation simulation = new Simulation(world(INLINE), Pacing.FAST)) {
            simulation.loop().run(30);
            WorldFile.save(saved, simulation.descriptionNow());
            simulation.loop().run(30);
            expected = speed(simulation);
        }
        assertThat(Files.readString(saved)).contains("law push \"A constant force.\"");
        try (Simulation simulation = new Simulation(WorldFile.load(saved), Pacing.FAST)) {
            simulation.loop().run(30);
            assertThat(speed(simulation)).isEqualTo(expected);
            assertThat(simulation.physics().laws().loaded())
                    .extracting(PhysicsLaw::name)
                    .contains("push");
        }
    }

    private static SimulationImage atStart(Simulation simulation) {
        simulation.loop().run(0);
        return simulation.keep();
    }

    @Test
    void excludedLibrariesDoNotAct() throws Exception {
        LawPath path = LawPath.ofShipped().without(Set.of("push"));
        try (Simulation simulation = new Simulation(world(INLINE), Pacing.FAST, path)) {
            simulation.loop().run(60);
            assertThat(speed(simulation)).isZero();
            assertThat(simulation.physics().laws().loaded())
                    .extracting(PhysicsLaw::name)
                    .containsExactly("newton_motion");
        }
        try (Simulation restored = new Simulation(world(INLINE), Pacing.FAST);
                SimulationImage image = atStart(restored);
                Simulation without = new Simulation(world(INLINE), Pacing.FAST, path, image)) {
            without.unloadExcluded();
            without.loop().run(60);
            assertThat(speed(without)).isZero();
            assertThatThrownBy(
                            () ->
                                    without.physics()
                                            .laws()
                                            .load(
                                                    60,
                                                    without.engine()
                                                            .prepareText(
                                                                    "push.law",
                                                                    restored.physics()
                                                                            .laws()
                                                                            .libraries()
                                                                            .getLast()
                                                                            .bytes()),
                                                    Map.of(),
                                                    folder.resolve("push.law")))
                    .hasMessageContaining("'push' is excluded by --without-law");
        }
    }

    @Test
    void aLawThatWritesLessThanThePropertysMinimumFails() throws Exception {
        String cooling =
                """
                reve: 1
                name: frozen
                frame: {rate: 60, steps: 1}
                properties:
                  - {name: temperature, kind: body, unit: K, min: 0}
                laws:
                  - newton_motion
                  - text: |
                      law cooling "Cools below absolute zero."
                        each body has temperature in K
                        each body: temperature += -60 K/s dt
                items:
                  - {name: stone, physics: {mass: 2 kg, temperature: 2.5 K}}
                """;
        Path saved = folder.resolve("saved.yaml");
        try (Simulation simulation =
                new Simulation(
                        WorldFile.parse("frozen.yaml", cooling.getBytes(StandardCharsets.UTF_8)),
                        Pacing.FAST)) {
            simulation.loop().run(5);
            assertThat(simulation.events().faults())
                    .singleElement()
                    .satisfies(
                            fault -> {
                                assertThat(fault.frame()).isEqualTo(3);
                                assertThat(fault.fields())
                                        .containsEntry("library", "cooling")
                                        .containsEntry("property", "temperature")
                                        .containsEntry("item", "stone");
                                assertThat(fault.fields().get("message"))
                                        .asString()
                                        .contains("wrote -0.5", ", expected 0 or more");
                            });
            assertThat(
                            simulation
                                    .world()
                                    .find("stone")
                                    .orElseThrow()
                                    .physics()
                                    .scalar("temperature"))
                    .isEqualTo(0.5);
            WorldFile.save(saved, simulation.descriptionNow());
        }
        assertThat(WorldFile.load(saved).name()).isEqualTo("frozen");
    }

    private static Simulation parsed(String text) throws Exception {
        return new Simulation(
                WorldFile.parse("world.yaml", text.getBytes(StandardCharsets.UTF_8)), Pacing.FAST);
    }

    private static double value(Simulation simulation, String item, String property) {
        return simulation.world().find(item).orElseThrow().physics().scalar(property);
    }

    /**
     * The law {@code heat} uses properties that the world file declares, also of springs. A second
     * law reads what the first one wrote.
     */
    @Test
    void heatFlowsThroughSpringsByPropertiesOfTheWorldFile() throws Exception {
        String world =
                """
                reve: 1
                name: bar
                frame: {rate: 60, steps: 2}
                properties:
                  - {name: temperature, kind: body, unit: K, min: 0}
                  - {name: heating, kind: body, unit: W}
                  - {name: conductivity, kind: spring, unit: W/K}
                laws:
                  - text: |
                      law heat
                        each body: heating = 0
                        each spring from a to b:
                          let q = conductivity * (a.temperature - b.temperature)
                          a.heating -= q;  b.heating += q
                  - text: |
                      law warming
                        parameter capacity = 100 J/K
                        each body: temperature += heating dt / capacity
                items:
                  - {name: hot, physics: {mass: 1 kg, temperature: 400 K}}
                  - {name: cold, physics: {mass: 1 kg, temperature: 300 K}}
                  - {name: bar, kind: spring, physics: {end1: hot, end2: cold, conductivity: 5 W/K}}
                """;
        try (Simulation simulation = parsed(world)) {
            simulation.loop().run(20 * 60);
            double hot = value(simulation, "hot", "temperature");
            double cold = value(simulation, "cold", "temperature");
            // The difference decays by the factor 1 - 2 k dt / C in each step.
            double factor = Math.pow(1 - 2 * 5.0 / 100 / 120, 20 * 120);
            assertThat(hot - cold).isCloseTo(100 * factor, within(1e-9));
            assertThat(hot - cold)
                    .isCloseTo(100 * Math.exp(-2 * 5.0 / 100 * 20), within(0.01 * 100 * factor));
            assertThat(hot + cold).isCloseTo(700, within(1e-9));
        }
    }

    @Test
    void aLawActsOnTheRowsOfAKindOfTheWorldFile() throws Exception {
        String world =
                """
                reve: 1
                name: kitchen
                frame: {rate: 60, steps: 1}
                properties:
                  - {name: water, kind: boiler, unit: kg}
                  - {name: power, kind: boiler, unit: W}
                  - {name: temperature, kind: boiler, unit: K, min: 0}
                laws:
                  - text: |
                      law boiling
                        parameter c = 4186 J/kg/K
                        each boiler:
                          temperature = min(373 K, temperature + power dt / (c water))
                items:
                  - {name: small, kind: boiler, physics: {water: 1 kg, power: 2 kW, temperature: 293 K}}
                  - {name: large, kind: boiler, physics: {water: 4 kg, power: 2 kW, temperature: 293 K}}
                """;
        try (Simulation simulation = parsed(world)) {
            simulation.loop().run(180 * 60);
            assertThat(value(simulation, "small", "temperature")).isEqualTo(373);
            assertThat(value(simulation, "large", "temperature"))
                    .isCloseTo(293 + 2000.0 * 180 / (4186 * 4), within(1e-8));
        }
    }

    /** A world in which a stone swings, and a place for a law that observes it. */
    private static final String SWING =
            """
            reve: 1
            name: swing
            frame: {rate: 60, steps: 10}
            properties:
              - {name: fastest, kind: body, unit: m/s}
            laws:
              - text: |
                  law well
                    each body: energy = 1/2 * 8 N/m position^2
              - newton_motion
            #
            items:
              - name: stone
                physical: {location: [3, 0, 4]}
                physics: {mass: 2 kg}
            """;

    @Test
    void aLawOfPhaseObserveRecordsIntoThePropertyOfTheWorldFileOnly() throws Exception {
        String watch =
                """
                  - text: |
                      law watch
                        phase observe
                        each body has fastest in m/s, path in m
                        each body:
                          fastest = max(fastest, |velocity|)
                          path += |velocity| dt
                """;
        try (Simulation plain = parsed(SWING);
                Simulation watched = parsed(SWING.replace("#\n", watch))) {
            for (Simulation each : new Simulation[] {plain, watched}) {
                each.loop().run(90);
                assertThat(each.events().faults()).isEmpty();
            }
            // The amplitude is 5 m and the frequency 2 / s. The world passes the middle in 0.79 s.
            assertThat(value(watched, "stone", "fastest")).isCloseTo(10, within(0.01));
            assertThat(value(plain, "stone", "fastest")).isZero();
            var stones = new Simulation[] {plain, watched};
            double[][] places = new double[2][];
            double[][] velocities = new double[2][];
            for (int i = 0; i < 2; i++) {
                var stone = stones[i].world().find("stone").orElseThrow();
                places[i] = stone.physical().location();
                velocities[i] = stone.physics().vector("velocity");
            }
            assertThat(places[1]).containsExactly(places[0]);
            assertThat(velocities[1]).containsExactly(velocities[0]);
        }
    }

    @Test
    void aLawOfPhaseObserveThatMovesBodiesIsRefused() throws Exception {
        String moving =
                """
                  - text: |
                      law watch
                        phase observe
                        each body: velocity = 0
                """;
        assertThatThrownBy(() -> parsed(SWING.replace("#\n", moving)).close())
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining("watch.law:3:14: 'velocity' cannot be set in phase observe");
    }
}
