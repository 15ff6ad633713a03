// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.fail;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.world.OffHeapArena;
import reve.core.world.World;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.TreeMap;

/**
 * Random valid files build the intended world. A file with random damage is refused with a message,
 * or it can be built. The seed is printed. {@code -Dreve.test.seed=N} repeats it.
 */
class WorldFileGeneratedTest {
    private static final int FILES = 200;
    private static final int MUTATIONS = Integer.getInteger("reve.file.mutants", 1500);

    private final long seed = Seed.of("world files");
    private final Random random = new Random(seed);

    /** A file, and the masses and velocities [SI] that it states, by item name. */
    private record Generated(
            String text, Map<String, Double> mass, Map<String, double[]> velocity, int springs) {}

    private static final String[][] MASS_UNITS = {{"kg", "1"}, {"g", "1e-3"}, {"t", "1e3"}};
    private static final String[][] SPEED_UNITS = {{"m/s", "1"}, {"km/s", "1e3"}, {"cm/s", "0.01"}};

    private Generated generate() {
        var text = new StringBuilder("reve: 1\nname: generated " + random.nextInt() + "\n");
        if (random.nextBoolean()) {
            text.append("frame: {rate: ").append(1 + random.nextInt(10_000)).append("}\n");
        }
        Map<String, Double> mass = new TreeMap<>();
        Map<String, double[]> velocity = new TreeMap<>();
        int bodies = 2 + random.nextInt(5);
        int springs = random.nextInt(3);
        List<String> items = new ArrayList<>();
        for (int i = 0; i < bodies; i++) {
            String[] massUnit = MASS_UNITS[random.nextInt(MASS_UNITS.length)];
            String[] speedUnit = SPEED_UNITS[random.nextInt(SPEED_UNITS.length)];
            double m = random.nextInt(1000);
            double[] v = random.doubles(3, -100, 100).toArray();
            mass.put("b" + i, m * Double.parseDouble(massUnit[1]));
            velocity.put(
                    "b" + i,
                    new double[] {
                        v[0] * Double.parseDouble(speedUnit[1]),
                        v[1] * Double.parseDouble(speedUnit[1]),
                        v[2] * Double.parseDouble(speedUnit[1])
                    });
            items.add(
                    "{name: b"
                            + i
                            + ", physical: {shape: box, size: [1, 2, 3], colour: \"#0a0b0c\""
                            + ", location: ["
                            + i
                            + ", 0, 0]}, semantic: {class: x, n: "
                            + i
                            + "}, access: {push: {parameters: {p: {components: 3, unit: N*s}},"
                            + " effects: [{impulse: $p}, {symbol: pushed, to: true}]}}, physics:"
                            + " {mass: "
                            + m
                            + " "
                            + massUnit[0]
                            + ", velocity: "
                            + v[0]
                            + " "
                            + v[1]
                            + " "
                            + v[2]
                            + " "
                            + speedUnit[0]
                            + "}}");
        }
        for (int i = 0; i < springs; i++) {
            int end = random.nextInt(bodies);
            items.add(
                    "{name: s"
                            + i
                            + ", kind: spring, physics: {springConstant: 3 N/m, length: 2, "
                            + "end1: b"
                            + end
                            + ", end2: b"
                            + (end + 1) % bodies
                            + "}}");
        }
        Collections.shuffle(items, random);
        text.append("items:\n");
        items.forEach(item -> text.append("  - ").append(item).append('\n'));
        return new Generated(text.toString(), mass, velocity, springs);
    }

    @Test
    void rightFilesBuildWhatTheySay() throws WorldFileException {
        for (int n = 0; n < FILES; n++) {
            Generated generated = generate();
            try (var arena = new OffHeapArena()) {
                World world = WorldFileTest.parse(generated.text()).build(arena);
                generated
                        .mass()
                        .forEach(
                                (name, kilograms) ->
                                        assertThat(
                                                        world.find(name)
                                                                .orElseThrow()
                                                                .physics()
                                                                .scalar("mass"))
                                                .as("mass of %s, seed %d", name, seed)
                                                .isCloseTo(kilograms, within(kilograms)));
                generated
                        .velocity()
                        .forEach(
                                (name, v) -> {
                                    double[] found =
                                            world.find(name)
                                                    .orElseThrow()
                                                    .physics()
                                                    .vector("velocity");
                                    for (int axis = 0; axis < 3; axis++) {
                                        assertThat(found[axis])
                                                .as("velocity of %s, seed %d", name, seed)
                                                .isCloseTo(v[axis], within(v[axis]));
                                    }
                                });
                assertThat(world.table("spring").physicsRowCount()).isEqualTo(generated.springs());
            }
        }
    }

    /** Returns a tolerance of two roundings. */
    private static org.assertj.core.data.Offset<Double> within(double value) {
        return org.assertj.core.api.Assertions.within(2 * Math.ulp(value));
    }

    @Test
    void damagedFilesAreRefusedInAnOrderlyWayOrCanBeBuilt() {
        int refused = 0;
        for (int n = 0; n < MUTATIONS; n++) {
            String text = mutate(generate().text());
            try (var arena = new OffHeapArena()) {
                WorldFileTest.parse(text).build(arena);
            } catch (WorldFileException orderly) {
                refused++;
                long lines = text.chars().filter(c -> c == '\n').count() + 1;
                assertThat(orderly.problems())
                        .isNotEmpty()
                        .isSorted()
                        .allMatch(
                                problem ->
                                        problem.line() >= 1
                                                && problem.line() <= lines + 1
                                                && problem.column() >= 1
                                                && !problem.message().isBlank());
            } catch (RuntimeException | StackOverflowError crash) {
                fail("seed " + seed + ", file\n" + text, crash);
            }
        }
        assertThat(refused)
                .as("mutations that did damage, seed %d", seed)
                .isGreaterThan(MUTATIONS / 4);
    }

    private static final String[] SNIPPETS = {
        "",
        " ",
        "\n",
        "\t",
        ":",
        ": ",
        "{",
        "}",
        "[",
        "]",
        ",",
        "-",
        "- ",
        "#",
        "'",
        "\"",
        "&a ",
        "*a",
        "!t ",
        "|",
        ">",
        "%",
        "@",
        "~",
        "$p",
        "$",
        "0",
        "-1",
        "1e400",
        "1e-400",
        ".nan",
        ".inf",
        "NaN",
        "null",
        "true",
        "kg",
        "°C",
        "world",
        "b0",
        "\0",
        "\u2028",
        "é",
        "\ud83d\ude00",
        "99999999999999999999",
        "0x",
        "name",
        "physics: {}"
    };

    private String mutate(String text) {
        int at = random.nextInt(text.length());
        int end = Math.min(text.length(), at + random.nextInt(12));
        String snippet = SNIPPETS[random.nextInt(SNIPPETS.length)];
        return switch (random.nextInt(4)) {
            case 0 -> text.substring(0, at) + snippet + text.substring(at);
            case 1 -> text.substring(0, at) + snippet + text.substring(end);
            case 2 -> text.substring(0, at) + text.substring(at, end) + text.substring(at);
            default ->
                    new String(
                            flip(text.getBytes(StandardCharsets.UTF_8)),
                            StandardCharsets.ISO_8859_1);
        };
    }

    private byte[] flip(byte[] bytes) {
        bytes[random.nextInt(bytes.length)] ^= (byte) (1 << random.nextInt(8));
        return bytes;
    }
}
