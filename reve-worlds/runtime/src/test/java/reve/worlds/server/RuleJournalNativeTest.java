// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.EditReader;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.rule.Rule;
import reve.worlds.journal.Journal;
import reve.worlds.journal.SimulationImage;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Rules that programs change while a world runs, in the store of the world. */
class RuleJournalNativeTest {
    private static final String WORLD =
            """
            reve: 1
            name: ruled
            laws: [newton_motion]
            rules: {heavy: physics.mass > 2.0, cold: 'true', pair: semantic.heavy}
            items:
              - {name: a, physical: {shape: sphere, radius: 1}, physics: {mass: 1}}
              - {name: b, physical: {location: [9, 0, 0]}, physics: {mass: 3, velocity: [1, 0, 0]}}
            """;

    @TempDir private Path folder;
    private final List<String> problems = new ArrayList<>();

    private StoredWorld open(String world) throws Exception {
        WorldDescription description =
                WorldFile.parse("ruled.yaml", world.getBytes(StandardCharsets.UTF_8));
        return StoredWorld.open(
                new StoreAddress.InFile(folder.resolve("my.db")),
                SqliteStore.Durability.NORMAL,
                description,
                Path.of("."),
                Pacing.FAST,
                LawPath.ofShipped(),
                problems::add);
    }

    private interface Work {
        void on(Simulation simulation) throws Exception;
    }

    /** Resumes the world, or begins it, and ends the run regularly. */
    private void run(String world, Work work) throws Exception {
        StoredWorld stored = open(world);
        try (Simulation simulation = stored.simulation();
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(1000, true),
                                stored.store(),
                                problems::add)) {
            work.on(simulation);
        }
        assertThat(problems).isEmpty();
    }

    /** Sets a rule, or removes it if the text is null. */
    private static void rule(Simulation simulation, String symbol, String text) throws Exception {
        List<Rule> now = simulation.description().rules();
        simulation.setRules(
                new EditReader(simulation.world().prototype())
                        .rules(now, Map.of(symbol, Optional.ofNullable(text))));
    }

    private static List<String> rules(Simulation simulation) {
        return simulation.description().rules().stream()
                .map(rule -> rule.symbol() + ": " + rule.source())
                .toList();
    }

    private static Map<String, Object> symbols(Simulation simulation, String item) {
        Map<String, Object> symbols =
                new LinkedHashMap<>(
                        simulation.world().find(item).orElseThrow().semantic().symbols());
        List.of("name", "class", "dimensions").forEach(symbols::remove);
        return symbols;
    }

    @Test
    void eachFrameAndTheLastImageContainTheChanges() throws Exception {
        List<String> before = new ArrayList<>();
        run(
                WORLD,
                simulation -> {
                    simulation.loop().run(3);
                    rule(simulation, "cold", null);
                    simulation.loop().run(2);
                    rule(simulation, "fast", "\"norm(physics.velocity) > 0.5\"");
                    rule(simulation, "heavy", "\"physics.mass > 0.5\"");
                    simulation.loop().run(2);
                    assertThat(symbols(simulation, "a"))
                            .isEqualTo(Map.of("heavy", true, "pair", true, "fast", false));
                    rule(simulation, "last", "\"1.0\""); // no frame follows
                    before.addAll(rules(simulation));
                });
        run(
                WORLD,
                simulation -> {
                    assertThat(rules(simulation)).isEqualTo(before);
                    simulation.loop().run(1);
                    assertThat(symbols(simulation, "a"))
                            .isEqualTo(
                                    Map.of(
                                            "heavy", true, "pair", true, "fast", false, "last",
                                            1.0));
                    assertThat(symbols(simulation, "b")).containsEntry("fast", true);
                });
    }

    @Test
    void aRewindKeepsTheRulesAndTheStoreToo() throws Exception {
        run(
                WORLD,
                simulation -> {
                    simulation.loop().run(2);
                    SimulationImage image = simulation.keep();
                    rule(simulation, "fast", "\"true\"");
                    simulation.loop().run(2);
                    simulation.rewind(image);
                    simulation.loop().run(2);
                    assertThat(symbols(simulation, "a")).containsEntry("fast", true);
                });
        run(
                WORLD,
                simulation -> {
                    simulation.loop().run(1);
                    assertThat(symbols(simulation, "a")).containsEntry("fast", true);
                });
    }

    /** The symbols are in the images of the store, and nothing would ever remove them. */
    @Test
    void symbolsOfRulesThatTheWorldDoesNotHaveAnyMoreAreRemoved() throws Exception {
        run(
                WORLD,
                simulation -> {
                    rule(simulation, "kinds", "{\"is\": \"item.kind\"}");
                    simulation.loop().run(2);
                });
        run(
                WORLD.replace(", cold: 'true'", ""),
                simulation -> {
                    assertThat(symbols(simulation, "a")).doesNotContainKey("cold");
                    rule(simulation, "kinds", null);
                    simulation.loop().run(1);
                    assertThat(symbols(simulation, "a"))
                            .isEqualTo(Map.of("heavy", false, "pair", false));
                });
        run(WORLD, simulation -> assertThat(rules(simulation)).hasSize(3));
    }

    @Test
    void aChangeThatNoLongerFitsIsReportedAndTheWorldContinues() throws Exception {
        run(
                WORLD,
                simulation -> {
                    rule(simulation, "sum", "\"semantic.pair ? 1.0 : 2.0\"");
                    rule(simulation, "heavy", "\"physics.mass > 0.5\"");
                    simulation.loop().run(2);
                });
        // The type that the world file now declares for the symbol is another one.
        String typed = WORLD.replace("rules:", "symbols: {sum: {type: text}}\nrules:");
        StoredWorld stored = open(typed);
        try (Simulation simulation = stored.simulation()) {
            assertThat(problems).hasSize(1);
            assertThat(problems.getFirst())
                    .contains(
                            "my.db", "rule sum: ", "is a number", "continues without this change");
            simulation.loop().run(1);
            assertThat(symbols(simulation, "a"))
                    .isEqualTo(Map.of("heavy", true, "cold", true, "pair", true));
        } finally {
            stored.store().close();
        }
    }
}
