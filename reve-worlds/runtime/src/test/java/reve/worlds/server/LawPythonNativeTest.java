// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.ItemDefinition;
import reve.core.world.Shape;
import reve.pe.LedgerLine;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.PythonLaw;
import reve.pe.Status;
import reve.pe.adapter.Quarantined;
import reve.pe.hosted.Hosts;
import reve.worlds.Product;

import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** Laws in Python, in the engine's process. */
class LawPythonNativeTest {
    private static final double OMEGA = 0.5;
    private static final double DT = 1.0 / 60;

    /** A law. Some tests replace its last line or a declaration. */
    private static final String SPIN =
            """
            import numpy
            import vesper

            OMEGA = numpy.array([0.0, 0.5, 0.0])  # rad/s


            @vesper.law(phase="force")
            def spin(
                velocity: vesper.Read("body", "m/s"),
                mass: vesper.Read("body", "kg"),
                force: vesper.Accumulate("body", "N"),
                dt,
                time,
                share: vesper.Parameter("1", default=1, least=0, most=2),
            ):
                "Coriolis force of a turning frame."
                force -= share * 2 * mass[:, None] * numpy.cross(OMEGA, velocity)
            """;

    private static final String LINE =
            "force -= share * 2 * mass[:, None] * numpy.cross(OMEGA, velocity)";
    private static final String TWIN =
            """
            law twin
              parameter omega = (0, 0.5, 0) 1/s
              each body:
                force -= 2 mass (omega × velocity)
            """;
    private static Hosts hosts;

    @TempDir private Path folder;

    @BeforeAll
    static void start() {
        hosts = new Hosts(Product.nativeFolder().resolve("vesper-host"), 0);
    }

    @AfterAll
    static void stop() {
        hosts.close();
    }

    private WorldDescription world(String laws) throws Exception {
        return WorldFile.load(
                Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: turning
                        laws: %s
                        items:
                          - name: stone
                            physical: {shape: sphere, radius: 1 m, location: [0, 0, 0]}
                            physics: {mass: 2 kg, velocity: [3, 1, 4]}
                          - name: pebble
                            physical: {shape: sphere, radius: 1 m, location: [50, 0, 0]}
                            physics: {mass: 0.3 kg, velocity: [-1, 0, 2]}
                        """
                                .formatted(laws)));
    }

    private LawPath path(boolean trusted) {
        return new LawPath(
                        LawPath.ofShipped().shipped(),
                        Optional.empty(),
                        Optional.empty(),
                        trusted,
                        EnginePlace.hosted(hosts, Duration.ofSeconds(10)),
                        false,
                        Set.of(),
                        Sandboxed.NONE)
                .forWorld(folder);
    }

    private void write(String file, String text) throws Exception {
        Files.writeString(Files.createDirectories(folder.resolve("laws")).resolve(file), text);
    }

    private Simulation simulate(String laws) throws Exception {
        return new Simulation(world(laws), Pacing.FAST, path(true));
    }

    private static double[] velocity(Simulation simulation, String item) {
        return simulation.world().find(item).orElseThrow().physics().vector("velocity");
    }

    /**
     * The velocity vz + i vx rotates about y. In each step, newton_motion multiplies it by 1 - 2 i
     * Ω dt. The closed form is a power of this factor.
     */
    @Test
    void aFreeBodyTurnsAsTheClosedFormSays() throws Exception {
        write("spin.py", SPIN);
        try (Simulation simulation = simulate("[newton_motion, spin]")) {
            int steps = 600;
            simulation.loop().run(steps);
            double growth = Math.pow(Math.hypot(1, 2 * OMEGA * DT), steps);
            double angle = -steps * Math.atan2(2 * OMEGA * DT, 1);
            double z = 4 * Math.cos(angle) - 3 * Math.sin(angle);
            double x = 4 * Math.sin(angle) + 3 * Math.cos(angle);
            double[] found = velocity(simulation, "stone");
            assertThat(found[0]).isCloseTo(growth * x, within(1e-11));
            assertThat(found[1]).isEqualTo(1);
            assertThat(found[2]).isCloseTo(growth * z, within(1e-11));
        }
    }

    @Test
    void itEqualsTheSameLawAsTextExceptForRounding() throws Exception {
        write("spin.py", SPIN);
        write("twin.law", TWIN);
        try (Simulation python = simulate("[newton_motion, spin]");
                Simulation text = simulate("[newton_motion, twin]")) {
            for (Simulation each : new Simulation[] {python, text}) {
                each.loop().run(300);
            }
            for (String item : new String[] {"stone", "pebble"}) {
                assertThat(velocity(python, item))
                        .containsExactly(velocity(text, item), within(1e-13));
            }
        }
    }

    @Test
    void aParameterHasTheValueOfTheWorldFile() throws Exception {
        write("spin.py", SPIN);
        try (Simulation simulation =
                simulate("[newton_motion, {name: spin, parameters: {share: 0}}]")) {
            simulation.loop().run(60);
            assertThat(velocity(simulation, "stone")).containsExactly(3, 1, 4);
        }
    }

    /** The diameter of a ball grows by 0.3 m/s. */
    @Test
    void aLawMayChangeTheSizesOfBodies() throws Exception {
        write(
                "grow.py",
                """
                import vesper


                @vesper.law(phase="constrain")
                def grow(size: vesper.ReadWrite("body", "m"), dt):
                    "Balls grow."
                    size += 0.3 * dt
                """);
        for (String prototype : new String[] {"si-f64", "si-f32"}) {
            try (Simulation simulation =
                    simulate("[newton_motion, grow]\nprototype: " + prototype)) {
                simulation.loop().run(60);
                assertThat(simulation.events().faults()).isEmpty();
                Shape shape = simulation.world().find("pebble").orElseThrow().physical().shape();
                assertThat(((Shape.Sphere) shape).radius()).isCloseTo(1.15, within(1e-12));
            }
        }
    }

    /** Laws on several threads take turns in the interpreter. */
    @Test
    void theNumberOfThreadsDoesNotChangeTheBits() throws Exception {
        write("spin.py", SPIN);
        write("turn.py", SPIN.replace("def spin", "def turn").replace("0.5, 0.0", "0.1, 0.7"));
        long[] hashes = new long[2];
        for (int i = 0; i < 2; i++) {
            String laws =
                    "[newton_motion, spin, turn, drag]\nframe: {threads: " + (1 + 3 * i) + "}";
            try (Simulation simulation = simulate(laws)) {
                simulation.loop().run(200);
                hashes[i] = simulation.engine().stateHash();
            }
        }
        assertThat(hashes[1]).isEqualTo(hashes[0]);
    }

    @Test
    void aWorldOfSinglePrecisionHasArraysOfSinglePrecision() throws Exception {
        write("spin.py", SPIN.replace(LINE, LINE + "\n    assert force.dtype == numpy.float32"));
        try (Simulation simulation = simulate("[newton_motion, spin]\nprototype: si-f32")) {
            simulation.loop().run(60);
            assertThat(simulation.physics().laws().quarantined()).isEmpty();
            assertThat(velocity(simulation, "stone")[0]).isNotCloseTo(3, within(0.1));
        }
    }

    /**
     * The columns move in memory when the number of their rows grows. The arrays move with them.
     */
    @Test
    void theArraysFollowTheColumns() throws Exception {
        write("spin.py", SPIN.replace(LINE, "force[:, 1] = 0.001 * mass * len(mass)"));
        try (Simulation simulation = simulate("[newton_motion, spin]")) {
            simulation.loop().run(1);
            for (int i = 0; i < 5000; i++) {
                simulation
                        .world()
                        .add(ItemDefinition.named("more " + i).physics("mass", 1).build());
            }
            double before = velocity(simulation, "stone")[1];
            simulation.loop().run(1);
            assertThat(velocity(simulation, "stone")[1] - before)
                    .isCloseTo(0.001 * 5002 * DT, within(1e-12));
        }
    }

    /** The memory of a law moves with the state of the engine. */
    @Test
    void timeAndMemoryOfTheLawsOwnAreKept() throws Exception {
        write(
                "count.py",
                """
                import vesper


                @vesper.law(phase="constrain")
                def count(
                    velocity: vesper.ReadWrite("body", "m/s"),
                    calls: vesper.Scratch("body", "1", components=2),
                    time,
                    dt,
                ):
                    calls[:, 0] += 1
                    velocity[:, 0] = calls[:, 0]
                    velocity[:, 1] = time
                    velocity[:, 2] = dt
                """);
        try (Simulation simulation = simulate("[newton_motion, count]")) {
            simulation.loop().run(7);
            assertThat(velocity(simulation, "stone")).containsExactly(7, 6 * DT, DT);
        }
    }

    @Test
    void aLawOfTheWorldsOwnNeedsTrust() throws Exception {
        write("spin.py", SPIN + "\n\nopen(" + quoted("mark") + ", 'w').close()\n");
        WorldDescription named = world("[newton_motion, spin]");
        assertThat(path(false).needsTrust("spin")).isTrue();
        assertThatThrownBy(() -> new Simulation(named, Pacing.FAST, path(false)).close())
                .hasMessageContaining("law 'spin' comes with the world, in laws/spin.py: a program")
                .hasMessageContaining("--trust");
        assertThat(folder.resolve("mark")).doesNotExist();
        simulate("[newton_motion, spin.py]").close();
        assertThat(folder.resolve("mark")).exists();
    }

    private String quoted(String file) {
        return "'" + folder.resolve(file) + "'";
    }

    @Test
    void anEngineInTheProcessOfItsClientRefusesIt() throws Exception {
        write("spin.py", SPIN);
        LawPath here =
                new LawPath(LawPath.ofShipped().shipped(), Optional.empty(), Optional.empty(), true)
                        .forWorld(folder);
        WorldDescription named = world("[newton_motion, spin]");
        assertThatThrownBy(() -> new Simulation(named, Pacing.FAST, here).close())
                .hasMessageContaining("spin.py is in Python")
                .hasMessageContaining("remove --engine in-process");
        try (Simulation other = new Simulation(world("[newton_motion]"), Pacing.FAST, here)) {
            assertThatThrownBy(() -> other.engine().prepare(SPIN.getBytes()))
                    .hasMessageContaining("laws in Python run only in the engine's own process");
        }
    }

    /** The name of a text must not make the text a program. */
    @Test
    void aTextWithTheNameOfAFileInPythonStaysAText() throws Exception {
        try (Simulation simulation = simulate("[newton_motion]")) {
            assertThatThrownBy(() -> simulation.engine().prepareText("spin.py", SPIN.getBytes()))
                    .isInstanceOf(PhysicsException.class)
                    .hasMessageContaining("spin.py:1:1: ");
            var text = simulation.engine().prepareText("spin.py", TWIN.getBytes());
            simulation.physics().laws().load(0, text, Map.of());
            simulation.loop().run(60);
            assertThat(velocity(simulation, "stone")[0]).isNotCloseTo(3, within(0.1));
        }
        assertThat(PreparedLibrary.isText(SPIN.getBytes())).isFalse();
        assertThat(PreparedLibrary.isText(TWIN.getBytes())).isTrue();
    }

    /** From the frame of the fault on, the world has the same bits as a world without the law. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    raise ValueError('three')         ¦ LAW_FAILED    ¦ law spin: spin.py:18: ValueError: three
                    mass[:, None][9]                  ¦ LAW_FAILED    ¦ law spin: spin.py:18: IndexError: index 9
                    velocity += 1                     ¦ LAW_FAILED    ¦ law spin: spin.py:18: ValueError: output array is read-only
                    velocity.setflags(write=True)     ¦ LAW_FAILED    ¦ law spin: spin.py:18: ValueError: cannot set WRITEABLE flag
                    return force                      ¦ LAW_FAILED    ¦ law spin: spin.py: spin returned ndarray, expected nothing
                    import sys; sys.exit(3)           ¦ LAW_FAILED    ¦ law spin: spin.py:18: SystemExit: 3
                    force += numpy.nan                ¦ LAW_MISBEHAVED ¦ law spin
                    import os; os._exit(0)            ¦ LAW_CRASHED   ¦ law spin: ended the engine's process
                    import ctypes; ctypes.string_at(0) ¦ LAW_CRASHED  ¦ law spin: ended the engine's process: SIGSEGV
                    """)
    void aFaultCostsOneRepeatedFrame(String line, Status status, String message) throws Exception {
        write("spin.py", SPIN.replace(LINE, "if time > 0.5:\n        " + line));
        try (Simulation faulty = simulate("[newton_motion, drag, spin]");
                Simulation without = simulate("[newton_motion, drag]")) {
            faulty.loop().run(90);
            without.loop().run(90);
            assertThat(faulty.physics().laws().quarantined())
                    .singleElement()
                    .satisfies(
                            reason -> {
                                assertThat(reason.library()).isEqualTo("spin");
                                assertThat(reason.status()).isEqualTo(status);
                                assertThat(reason.message()).contains(message);
                            })
                    .extracting(Quarantined::sha256)
                    .isEqualTo(LawFiles.sha256(Files.readAllBytes(folder.resolve("laws/spin.py"))));
            assertThat(faulty.engine().stateHash()).isEqualTo(without.engine().stateHash());
        }
    }

    /** A spring from the origin to each body, with its energy. */
    private static final String WELL =
            """
            import vesper


            @vesper.law(phase="force", claims="energy")
            def well(
                position: vesper.Read("body", "m"),
                force: vesper.Accumulate("body", "N"),
                stiffness: vesper.Parameter("N/m", default=2, least=0, doc="Pull"),
            ):
                "Spring from the origin to each body."
                force -= stiffness * position


            @vesper.energy(well)
            def well_energy(position, stiffness):
                return 0.5 * stiffness * (position**2).sum()
            """;

    /** The stone begins at the origin with 3, 1, 4 m/s, the pebble at 50 m with -1, 0, 2 m/s. */
    @Test
    void theLedgerHasThePotentialEnergyOfALaw() throws Exception {
        write("well.py", WELL);
        try (Simulation simulation =
                simulate("[velocity_verlet, {name: well, parameters: {stiffness: 0.3}}]")) {
            simulation.physics().setLedger(true);
            int frames = 120;
            simulation.loop().run(frames);
            assertThat(simulation.events().faults()).isEmpty();
            LedgerLine well =
                    simulation.physics().ledger().stream()
                            .filter(line -> line.name().equals("well"))
                            .findFirst()
                            .orElseThrow();
            assertThat(well.initialPotentialEnergy()).isCloseTo(0.5 * 0.3 * 50 * 50, within(1e-12));
            double time = frames * DT;
            double energy =
                    0.5 * 0.3 * (oscillation(2, 0, 26, time) + oscillation(0.3, 50, 5, time));
            assertThat(well.potentialEnergy())
                    .as("closed form of two oscillators")
                    .isCloseTo(energy, within(1e-3 * energy));
            assertThat(well.energy())
                    .as("work against the change of the potential energy")
                    .isCloseTo(0.5 * 0.3 * 50 * 50 - energy, within(1e-3 * energy));
        }
    }

    /**
     * Returns the square of the distance of an oscillator whose stiffness is 0.3 N/m.
     *
     * @param along initial place along x [m]
     * @param speedSquared square of the initial velocity [m^2/s^2]
     */
    private static double oscillation(double mass, double along, double speedSquared, double time) {
        double frequency = Math.sqrt(0.3 / mass);
        double cosine = Math.cos(frequency * time);
        double sine = Math.sin(frequency * time) / frequency;
        double product = along == 0 ? 0 : along * -1; // place times velocity; the stone has none
        return along * along * cosine * cosine
                + speedSquared * sine * sine
                + 2 * product * cosine * sine;
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    return 1 / 0                 ¦ LAW_FAILED ¦ law well: well.py:16: ZeroDivisionError
                    return None                  ¦ LAW_FAILED ¦ well_energy returned NoneType, expected a number, the potential energy in J
                    position += 1; return 0      ¦ LAW_FAILED ¦ law well: well.py:16: ValueError: output array is read-only
                    return float('inf')          ¦ LAW_MISBEHAVED ¦ law well: its potential energy is inf
                    """)
    void anEnergyThatFailsCostsItsLaw(String line, Status status, String message) throws Exception {
        write("well.py", WELL.replace("return 0.5 * stiffness * (position**2).sum()", line));
        try (Simulation simulation = simulate("[velocity_verlet, well]")) {
            simulation.physics().setLedger(true);
            simulation.loop().run(3);
            simulation.physics().ledger();
            simulation.loop().run(3);
            assertThat(simulation.physics().laws().quarantined())
                    .singleElement()
                    .satisfies(
                            reason -> {
                                assertThat(reason.status()).isEqualTo(status);
                                assertThat(reason.message()).contains(message);
                            });
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    well_energy(position, stiffness)  ¦ well_energy(position, stiff) ¦ well.py:15: an energy depends on what its law reads; well reads no 'stiff'; did you mean stiffness?
                    well_energy(position, stiffness)  ¦ well_energy(force)           ¦ well.py:15: an energy depends on what its law reads; well reads no 'force'
                    well_energy(position, stiffness)  ¦ well_energy(*position)       ¦ well.py:15: found *, ** or / among the arguments
                    @vesper.energy(well)              ¦ @vesper.energy(vesper)       ¦ expected a function with @vesper.law above
                    phase="force", claims="energy"    ¦ phase="observe"              ¦ well.py:
                    @vesper.energy(well)              ¦ `# no energy`                ¦ claims to conserve energy, but computes no potential energy
                    """)
    void aMistakeInAnEnergyIsRefused(String text, String wrong, String message) throws Exception {
        write("well.py", WELL.replace(text, wrong));
        assertThatThrownBy(() -> simulate("[velocity_verlet, well]").close())
                .hasMessageContaining(message);
    }

    private static final String SAIL =
            """
            import vesper

            KEPT = []


            @vesper.law(phase="force")
            def sail(
                wind: vesper.Field("world", "m/s"),
                warmth: vesper.Field("world", "K"),
                position: vesper.Read("body", "m"),
                velocity: vesper.Read("body", "m/s"),
                force: vesper.Accumulate("body", "N"),
            ):
                assert wind(position).shape == (2, 3) and wind(position[0]).shape == (3,)
                assert warmth(position).shape == (2,) and warmth(position[1]) == 7
                force += 2 * (wind(position) - velocity)
            """;

    private static final String BREEZE =
            """
            law breeze
              field wind at place = (0.5 1/s place.y, 0, 1 m/s^2 time)
              field warmth at place = 1 K/m place.y + 4 K
            """;

    private Simulation sailing(String sail, String breeze) throws Exception {
        write("sail.py", sail);
        write("breeze.law", breeze);
        write("twin.law", "law twin\n  each body: force += 2 kg/s (wind - velocity)\n");
        return regatta("breeze", "sail");
    }

    private Simulation regatta(String provider, String reader) throws Exception {
        return new Simulation(
                WorldFile.load(
                        Files.writeString(
                                folder.resolve("world.yaml"),
                                """
                                reve: 1
                                name: regatta
                                properties:
                                  - {name: wind, kind: world, type: field, components: 3, unit: m/s}
                                  - {name: warmth, kind: world, type: field, unit: K}
                                laws: [%s, %s, newton_motion]
                                items:
                                  - {name: low, physical: {location: [0, 1, 0]}, physics: {mass: 1}}
                                  - {name: high, physical: {location: [0, 3, 0]}, physics: {mass: 2}}
                                """
                                        .formatted(provider, reader))),
                Pacing.FAST,
                path(true));
    }

    @Test
    void aFieldHasTheBitsThatALawAsTextReads() throws Exception {
        try (Simulation python = sailing(SAIL, BREEZE);
                Simulation text = regatta("breeze", "twin")) {
            python.loop().run(90);
            text.loop().run(90);
            assertThat(python.physics().laws().quarantined()).isEmpty();
            assertThat(velocity(python, "high")).isEqualTo(velocity(text, "high"));
            assertThat(velocity(python, "high")[0]).isGreaterThan(1);
            assertThat(python.engine().stateHash()).isEqualTo(text.engine().stateHash());
        }
    }

    /** The same fields as BREEZE. */
    private static final String PYTHON_BREEZE =
            """
            import numpy
            import vesper


            @vesper.field("m/s")
            def wind(place, time, shear: vesper.Parameter("1/s", default=0.5, doc="Growth")):
                "Wind that grows with the height and the time."
                zero = numpy.zeros(len(place))
                return numpy.stack([shear * place[:, 1], zero, zero + time], axis=1)


            @vesper.field("K")
            def warmth(place):
                "Warmth that grows with the height."
                return place[:, 1] + 4
            """;

    private Simulation sailingInPython(String wind, String reader) throws Exception {
        writeLaws(wind);
        return regatta("wind", reader);
    }

    private void writeLaws(String wind) throws Exception {
        write("sail.py", SAIL);
        write("twin.law", "law twin\n  each body: force += 2 kg/s (wind - velocity)\n");
        write("breeze.law", BREEZE);
        write("wind.py", wind);
    }

    /** A law as text and a law in Python read it. */
    @ParameterizedTest
    @ValueSource(strings = {"twin", "sail"})
    void aFileInPythonProvidesFieldsLikeAText(String reader) throws Exception {
        writeLaws(PYTHON_BREEZE);
        try (Simulation python = regatta("wind", reader);
                Simulation text = regatta("breeze", reader)) {
            python.loop().run(90);
            text.loop().run(90);
            assertThat(python.events().faults()).isEmpty();
            assertThat(velocity(python, "high")).isEqualTo(velocity(text, "high"));
            assertThat(velocity(python, "high")[0]).isGreaterThan(1);
            assertThat(python.engine().stateHash()).isEqualTo(text.engine().stateHash());
        }
    }

    @Test
    void aParameterOfAFieldIsSetAndChanged() throws Exception {
        try (Simulation simulation = sailingInPython(PYTHON_BREEZE, "twin")) {
            simulation.loop().run(30);
            double slow = velocity(simulation, "high")[0];
            simulation.physics().laws().setParameters(31, "wind", Map.of("wind.shear", 5.0));
            simulation.loop().run(30);
            assertThat(velocity(simulation, "high")[0]).isGreaterThan(4 * slow);
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    raise ValueError('calm')       ¦ wind.py:9: ValueError: calm at (0, 1, 0) m, where law twin reads it
                    return numpy.log(-place)       ¦ wind.py: field wind has no finite value at (0, 1, 0) m, where law twin reads it
                    return place[:, 1]             ¦ wind returned the shape (1,) for 1 positions, expected (1, 3) at (0, 1, 0) m
                    return 3.0                     ¦ wind returned the shape () for 1 positions, expected (1, 3)
                    place[0] = 1                   ¦ wind.py:9: ValueError: assignment destination is read-only
                    """)
    void aFieldThatFailsIsTheFaultOfItsFile(String line, String message) throws Exception {
        String wrong =
                PYTHON_BREEZE.replace(
                        "return numpy.stack([shear * place[:, 1], zero, zero + time], axis=1)",
                        line);
        try (Simulation simulation = sailingInPython(wrong, "twin")) {
            simulation.loop().run(10);
            assertThat(simulation.physics().laws().quarantined())
                    .singleElement()
                    .satisfies(
                            reason -> {
                                assertThat(reason.library()).isEqualTo("wind");
                                assertThat(reason.message()).contains(message);
                            });
            assertThat(velocity(simulation, "high")).as("twin rests").isEqualTo(new double[3]);
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    @vesper.field("K")        ¦ @vesper.field("m")          ¦ wind.py:13: the unit of 'warmth' is K, @vesper.field says m
                    @vesper.field("K")        ¦ @vesper.field               ¦ found @vesper.field without brackets
                    def warmth(place)         ¦ def warm(place)             ¦ wind.py:13: the world has no field 'warm'; did you mean warmth?
                    def warmth(place)         ¦ def warmth()                ¦ wind.py:13: the first argument of the field warmth are the positions
                    def warmth(place)         ¦ def warmth(place, dt)       ¦ wind.py:13: a field depends on positions, time and parameters; dt is none of them
                    """)
    void aMistakeInAFieldIsRefused(String text, String wrong, String message) throws Exception {
        assertThatThrownBy(
                        () -> sailingInPython(PYTHON_BREEZE.replace(text, wrong), "twin").close())
                .hasMessageContaining(message);
    }

    /** The line of a field marks a file as a program, too. */
    @Test
    void aFileWithFieldsOnlyNeedsTrust() throws Exception {
        assertThat(PreparedLibrary.isText(PYTHON_BREEZE.getBytes())).isFalse();
        assertThat(PythonLaw.nameOf(PYTHON_BREEZE.getBytes())).isEqualTo("wind.py");
        write("wind.py", PYTHON_BREEZE);
        assertThat(path(false).needsTrust("wind")).isTrue();
    }

    @Test
    void aFieldIsReadInTheUnitOfTheAnnotation() throws Exception {
        String sail =
                SAIL.replace("Field(\"world\", \"m/s\")", "Field(\"world\", \"km/h\")")
                        .replace("2 * (wind(position)", "2 * (wind(position) / 3.6");
        try (Simulation python = sailing(sail, BREEZE);
                Simulation text = regatta("breeze", "twin")) {
            python.loop().run(30);
            text.loop().run(30);
            assertThat(velocity(python, "high")[0])
                    .isCloseTo(velocity(text, "high")[0], within(1e-12))
                    .isGreaterThan(0.1);
        }
    }

    @Test
    void aFieldThatIsNotFiniteIsTheFaultOfItsProvider() throws Exception {
        String lost = BREEZE.replace("0.5 1/s place.y", "1 m^2/s / (place.y - 1 m)");
        try (Simulation simulation = sailing(SAIL, lost)) {
            simulation.loop().run(10);
            assertThat(simulation.physics().laws().quarantined())
                    .singleElement()
                    .satisfies(
                            reason -> {
                                assertThat(reason.library()).isEqualTo("breeze");
                                assertThat(reason.message())
                                        .contains("breeze.law:2:", "divides by zero at (0, 1, 0) m")
                                        .contains("where law sail reads it");
                            });
            assertThat(velocity(simulation, "high")).as("sail rests").isEqualTo(new double[3]);
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    wind(position[:, :2])  ¦ ValueError: the positions for 'wind' have the shape (2, 2), expected (rows, 3) or (3,)
                    wind(1.0)              ¦ ValueError: the positions for 'wind' have the shape (), expected (rows, 3) or (3,)
                    KEPT.append(wind)      ¦ RuntimeError: the field 'wind' is valid during the call of the law only
                    """)
    void aWrongCallOfAFieldFailsTheLaw(String line, String message) throws Exception {
        String other =
                """


                @vesper.law(phase="constrain")
                def other(position: vesper.Read("body", "m")):
                    for kept in KEPT:
                        kept(position)
                """;
        String sail = SAIL.replace("force += 2", line + "\n    force += 2") + other;
        try (Simulation simulation = sailing(sail, BREEZE)) {
            simulation.loop().run(2);
            assertThat(simulation.physics().laws().quarantined())
                    .singleElement()
                    .satisfies(
                            reason -> {
                                assertThat(reason.library()).isEqualTo("sail");
                                assertThat(reason.message()).contains(message);
                            });
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            textBlock =
                    """
                    wind: vesper.Field("world", "m/s") ¦ wind: vesper.Read("world", "m/s") ¦ sail.py:8: 'wind' is a field, the annotation is vesper.Read; write vesper.Field('world', 'm/s')
                    wind: vesper.Field("world", "m/s") ¦ wind: vesper.Read("body", "m/s")  ¦ sail.py:8: 'wind' is a field of kind world, the annotation says 'body'; write vesper.Field('world', 'm/s')
                    wind: vesper.Field("world", "m/s") ¦ wind: vesper.Field("world", "N")  ¦ sail.py:8: the unit of 'wind' is m/s, the annotation says N
                    position: vesper.Read(             ¦ position: vesper.Field(           ¦ sail.py:10: 'position' is a column, the annotation is vesper.Field; write vesper.Read('body', 'm')
                    """)
    void aWrongAnnotationOfAFieldIsRefused(String right, String wrong, String message) {
        assertThat(SAIL).contains(right);
        assertThatThrownBy(() -> sailing(SAIL.replace(right, wrong), BREEZE).close())
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining(message);
    }

    /** A wrong file is refused when it is loaded. The message has the line. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '¦',
            quoteCharacter = '`',
            emptyValue = "",
            textBlock =
                    """
                    velocity: vesper.Read ¦ velocty: vesper.Read ¦ spin.py:9: body has no property 'velocty'; did you mean velocity?
                    "body", "kg"  ¦ "bodies", "kg" ¦ spin.py:10: there is no kind 'bodies' in this world; did you mean body?
                    "kg"          ¦ "kgg"          ¦ spin.py:10: unit
                    "kg"          ¦ 3              ¦ spin.py:10: the unit is 3, expected a text such as 'm/s'
                    "m/s"         ¦ "N"            ¦ spin.py:9: the unit of 'velocity' is m/s, the annotation says N
                    Read("body", "kg") ¦ Write("body", "kg") ¦ spin.py:10: the annotation of 'mass' is vesper.Write, and laws may use it as Read
                    vesper.Accumulate ¦ vesper.ReadWrite ¦ spin.py:11: the annotation of 'externalForce' is vesper.ReadWrite
                    dt,           ¦ step,          ¦ spin.py:12: step has no annotation, expected a column such as
                    vesper.Parameter("1", default=1, least=0, most=2) ¦ 3 ¦ spin.py:14: share has the annotation 3, expected
                    default=1     ¦ default=7      ¦ spin.py:14: default is 7.0, expected 0.0 to 2.0
                    `default=1, ` ¦ ``             ¦ spin.py:14: TypeError:
                    "force"       ¦ "froce"        ¦ spin.py:7: found phase='froce', expected @vesper.law(phase="force")
                    (phase="force") ¦ ``           ¦ spin.py:7: found @vesper.law without brackets
                    "force"       ¦ "observe"      ¦ spin.py:11: vesper.Accumulate is for laws of phase force, this one is observe
                    force -= share ¦ force = -share ¦ spin.py:17: 'force = …' makes another array and leaves the column unchanged
                    dt,           ¦ *dt,           ¦ spin.py:8: found *, ** or / among the arguments
                    import numpy  ¦ import nmupy   ¦ spin.py:1: ModuleNotFoundError:
                    force -=      ¦ force -==      ¦ spin.py:17:13: invalid syntax
                    def spin(     ¦ x = spin(      ¦ spin.py:8:1: invalid syntax
                    @vesper.law   ¦ @ vesper.law   ¦ spin.py: no line begins with @vesper.law
                    import vesper ¦ raise SystemExit ¦ spin.py:2: SystemExit
                    import vesper ¦ import os; os._exit(0) ¦ the library ended a trial process
                    """)
    void aWrongFileIsRefusedWithItsLine(String right, String wrong, String message)
            throws Exception {
        assertThat(SPIN).contains(right);
        write("spin.py", SPIN.replaceFirst(Pattern.quote(right), Matcher.quoteReplacement(wrong)));
        assertThatThrownBy(() -> simulate("[newton_motion, spin]").close())
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining(message);
    }
}
