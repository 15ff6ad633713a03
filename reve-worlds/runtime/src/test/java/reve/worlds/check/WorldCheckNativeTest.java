// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.MethodSource;

import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.world.Item;
import reve.core.world.WorldPrototype;
import reve.worlds.server.Simulation;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.List;
import java.util.Objects;
import java.util.Optional;
import java.util.regex.MatchResult;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * The check warns about worlds that would do nothing, fall for ever or diverge. A warning has the
 * line and the reason. There is no warning about worlds that work. Each world also runs, which
 * shows that the warning is true and that its remedy works.
 */
class WorldCheckNativeTest {
    private static final int SECOND = 60;
    private static final double OUT_OF_BOUNDS = 100;
    private static final Pattern EXPECTED = Pattern.compile("# (\\d+) (\\S+): (.*)");
    private static final Pattern REMEDY =
            Pattern.compile("write (frame: \\{rate: \\d+, steps: (\\d+)\\})");

    /** A world of a resource. It has the name of its world file. */
    private record Sample(String text) {
        WorldDescription world() throws WorldFileException {
            return WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8));
        }

        String head() {
            return text.lines().findFirst().orElseThrow();
        }

        @Override
        public String toString() {
            return text.lines()
                    .filter(line -> line.startsWith("name: "))
                    .findFirst()
                    .orElseThrow()
                    .substring("name: ".length());
        }
    }

    private static List<Sample> samples(String resource) throws IOException {
        try (InputStream file = WorldCheckNativeTest.class.getResourceAsStream(resource)) {
            String all =
                    new String(Objects.requireNonNull(file).readAllBytes(), StandardCharsets.UTF_8);
            return Arrays.stream(all.split("\n---\n")).skip(1).map(Sample::new).toList();
        }
    }

    static List<Sample> silent() throws IOException {
        return samples("silent.yaml");
    }

    static List<Sample> good() throws IOException {
        return samples("good.yaml");
    }

    @Test
    void thereAreFortyOfEach() throws IOException {
        assertThat(silent()).hasSizeGreaterThanOrEqualTo(40);
        assertThat(good()).hasSizeGreaterThanOrEqualTo(40);
    }

    @ParameterizedTest(name = "{0}")
    @MethodSource("silent")
    void aWorldThatDoesNotDoWhatItSaysIsWarnedOf(Sample sample) throws WorldFileException {
        Matcher expected = EXPECTED.matcher(sample.head());
        assertThat(expected.matches()).isTrue();
        try (Simulation simulation = new Simulation(sample.world(), Pacing.FAST)) {
            List<Problem> warnings = simulation.warnings(true);
            assertThat(warnings)
                    .extracting(Problem::toString)
                    .anySatisfy(
                            warning ->
                                    assertThat(warning)
                                            .startsWith("w:" + expected.group(1) + ":")
                                            .contains(": warning: ", expected.group(3)));
            assertThat(warnings).extracting(Problem::message).allMatch(text -> text.contains(";"));
            requireTrue(expected.group(2), simulation);
        }
    }

    @ParameterizedTest(name = "{0}")
    @MethodSource("silent")
    void theStepOfAWarningHolds(Sample sample) throws WorldFileException {
        try (Simulation simulation = new Simulation(sample.world(), Pacing.FAST)) {
            Optional<MatchResult> shortest =
                    simulation.warnings(true).stream()
                            .flatMap(warning -> REMEDY.matcher(warning.message()).results())
                            .max(
                                    Comparator.comparingInt(
                                            remedy -> Integer.parseInt(remedy.group(2))));
            if (shortest.isPresent()) {
                requireStable(sample.text(), shortest.get().group(1));
            }
        }
    }

    private static void requireStable(String text, String frame) throws WorldFileException {
        String better = text.replaceAll("(?m)^frame: .*\n", "") + "\n" + frame + "\n";
        try (Simulation simulation = new Simulation(new Sample(better).world(), Pacing.FAST)) {
            assertThat(simulation.warnings(true))
                    .noneMatch(warning -> REMEDY.matcher(warning.message()).find());
            simulation.loop().run(10 * SECOND);
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    @ParameterizedTest(name = "{0}")
    @MethodSource("good")
    void aWorldThatWorksIsNotWarnedOf(Sample sample) throws WorldFileException {
        try (Simulation simulation = new Simulation(sample.world(), Pacing.FAST)) {
            assertThat(simulation.warnings(true)).isEmpty();
            List<List<Double>> before = state(simulation);
            simulation.loop().run(SECOND);
            assertThat(simulation.events().faults()).isEmpty();
            if (!sample.head().equals("# -")) {
                assertThat(state(simulation)).isNotEqualTo(before);
            }
        }
    }

    private static void requireTrue(String claim, Simulation simulation) {
        List<List<Double>> before = state(simulation);
        switch (claim) {
            case "stays" -> {
                simulation.loop().run(SECOND);
                assertThat(state(simulation)).isEqualTo(before);
            }
            case "falls" -> {
                simulation.loop().run(SECOND);
                assertThat(bodies(simulation)).anyMatch(body -> body.physical().location()[1] < -1);
            }
            case "diverges" -> {
                simulation.loop().run(30 * SECOND);
                assertThat(
                                !simulation.events().faults().isEmpty()
                                        || state(simulation).stream()
                                                .flatMap(List::stream)
                                                .anyMatch(value -> Math.abs(value) > OUT_OF_BOUNDS))
                        .isTrue();
            }
            case "ends" -> {
                simulation.loop().run(SECOND);
                assertThat(simulation.events().faults()).isNotEmpty();
            }
            default -> assertThat(claim).isEqualTo("-");
        }
    }

    /** Returns the location and orientation of each body. */
    private static List<List<Double>> state(Simulation simulation) {
        List<List<Double>> state = new ArrayList<>();
        for (Item body : bodies(simulation)) {
            List<Double> numbers = new ArrayList<>();
            for (double value : body.physical().location()) {
                numbers.add(value);
            }
            for (double value : body.physical().orientation()) {
                numbers.add(value);
            }
            state.add(numbers);
        }
        return state;
    }

    private static List<Item> bodies(Simulation simulation) {
        return simulation.world().items().stream()
                .filter(item -> item.kind().equals(WorldPrototype.BODY))
                .toList();
    }
}
