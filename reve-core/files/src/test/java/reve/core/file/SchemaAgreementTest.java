// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;

import dev.harrel.jsonschema.Validator;
import dev.harrel.jsonschema.ValidatorFactory;

import org.junit.jupiter.api.Test;

import reve.core.Seed;

import java.io.IOException;
import java.net.URI;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Map;
import java.util.Random;

/**
 * The problems that an editor finds if it has only the shipped schema. The validator of this test
 * shares no code with the reader of world files. It reads a whole file with its items at once.
 */
class SchemaAgreementTest {
    private static final int MUTANTS = Integer.getInteger("reve.schema.mutants", 1500);
    private static final URI FILE = URI.create("urn:reve:world-file:1");
    private static final URI PART = URI.create("urn:reve:world-file:1#/$defs/part");
    private static final URI EXPERIMENT = URI.create("urn:reve:experiment:1");
    private final Validator editor = new ValidatorFactory().createValidator();

    SchemaAgreementTest() throws IOException {
        try (var in = WorldFile.class.getResourceAsStream("/reve-world.schema.json")) {
            editor.registerSchema(FILE, new String(in.readAllBytes(), StandardCharsets.UTF_8));
        }
    }

    @Test
    void everyWorldFileOfTheProjectIsAccepted() throws IOException {
        Map<String, Object> worlds = WorldTrees.worlds();
        assertThat(worlds).as("world files and whole worlds in documents").hasSizeGreaterThan(15);
        worlds.forEach((place, world) -> assertThat(saidBy(FILE, world)).as(place).isEmpty());
    }

    @Test
    void everyExperimentOfTheProjectIsAccepted() throws IOException {
        try (var in = WorldFile.class.getResourceAsStream("/reve-experiment.schema.json")) {
            editor.registerSchema(
                    EXPERIMENT, new String(in.readAllBytes(), StandardCharsets.UTF_8));
        }
        Map<String, Object> experiments = WorldTrees.experiments();
        assertThat(experiments).as("experiments of the project and of documents").hasSize(5);
        experiments.forEach(
                (place, experiment) ->
                        assertThat(saidBy(EXPERIMENT, experiment)).as(place).isEmpty());
    }

    @Test
    void everyIncludedFileIsAcceptedAsAPart() throws IOException {
        Map<String, Object> parts = WorldTrees.parts();
        WorldTrees.blocks()
                .forEach(
                        (place, text) -> {
                            if (text.contains("parts/wheels.yaml\nprefabs:")) {
                                parts.put(place, WorldTrees.loaded(text));
                            }
                        });
        assertThat(parts).as("files of the project and of documents").hasSizeGreaterThan(1);
        parts.forEach((place, part) -> assertThat(saidBy(PART, part)).as(place).isEmpty());
    }

    @Test
    void theMistakesInTheDocumentsAreShown() throws IOException {
        String mistakes =
                WorldTrees.blocks().values().stream()
                        .filter(text -> text.contains("name: mistakes"))
                        .findFirst()
                        .orElseThrow();
        assertThat(saidBy(FILE, WorldTrees.loaded(mistakes)))
                .anyMatch(error -> error.startsWith("/prototyp"));
    }

    /** The seed is printed; {@code -Dreve.test.seed=N} repeats it. */
    @Test
    void whatOneRefusesForItsFormTheOtherRefusesToo() throws IOException {
        long seed = Seed.of("mutants of worlds");
        var random = new Random(seed);
        List<Object> worlds =
                WorldTrees.worlds().values().stream()
                        .filter(world -> WorldTrees.json(world).length() < 20_000)
                        .toList();
        int refused = 0;
        for (int i = 0; i < MUTANTS; i++) {
            Object mutant = WorldTrees.copy(worlds.get(random.nextInt(worlds.size())));
            for (int changes = 1 + random.nextInt(2); changes > 0; changes--) {
                WorldTrees.mutate(mutant, random);
            }
            List<String> shown = saidBy(FILE, mutant);
            List<String> told = told(mutant);
            assertThat(told.isEmpty())
                    .as(
                            "seed %d, mutant %d%n%s%neditor: %s%nloader: %s",
                            seed, i, WorldTrees.json(mutant), shown, told)
                    .isEqualTo(shown.isEmpty());
            refused += shown.isEmpty() ? 0 : 1;
        }
        assertThat(refused).isBetween(MUTANTS / 4, MUTANTS * 19 / 20);
    }

    private List<String> saidBy(URI schema, Object world) {
        Validator.Result result = editor.validate(schema, WorldTrees.json(world));
        return result.isValid()
                ? List.of()
                : result.getErrors().stream()
                        .map(error -> error.getInstanceLocation() + ": " + error.getError())
                        .toList();
    }

    private static List<String> told(Object world) {
        var problems = new Problems("w");
        try {
            Node root =
                    YamlReader.read(
                            WorldTrees.json(world), problems, new Allowance(YamlReader.MAX_VALUES));
            SchemaCheck.check(root, problems);
            problems.throwIfAny();
            return List.of();
        } catch (WorldFileException refused) {
            return refused.problems().stream().map(Problem::toString).toList();
        }
    }
}
