// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.rule.Rule;
import reve.core.rule.Rules;
import reve.core.rule.SymbolSource;
import reve.core.world.Instrument;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.World;
import reve.core.world.WorldEvent;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Optional;

/** Symbols and sensors in Java that world files name. */
class ProvidersTest {
    private final OffHeapArena arena = new OffHeapArena();

    @AfterEach
    void free() {
        arena.close();
    }

    private static WorldDescription parse(String rest) throws WorldFileException {
        return WorldFile.parse("w", ("reve: 1\nname: w\n" + rest).getBytes(StandardCharsets.UTF_8));
    }

    private static WorldDescription readAgain(WorldDescription world)
            throws IOException, WorldFileException {
        Path file = Files.createTempFile("world", ".yaml");
        try {
            WorldFile.save(file, world);
            return WorldFile.load(file);
        } finally {
            Files.delete(file);
        }
    }

    private static Optional<Object> loud(World world, String item) {
        return world.find(item).orElseThrow().semantic().get("loud");
    }

    @Test
    void aRuleInJavaGivesItsItemsTheSymbol() throws Exception {
        WorldDescription description =
                parse(
                        """
                        rules: {loud: {java: test.loud, class: dog}}
                        items:
                          - {name: rex, semantic: {class: dog}}
                          - {name: tom, semantic: {class: cat}}
                          - {name: quiet, semantic: {class: dog}}
                          - {name: own, semantic: {class: dog, loud: never}}
                        """);
        World world = description.build(arena);
        new Rules(world, description.rules(), Rules.DEFAULT_STEPS).update(1);
        assertThat(loud(world, "rex")).contains("REX");
        assertThat(loud(world, "tom")).isEmpty();
        assertThat(loud(world, "quiet")).isEmpty();
        assertThat(loud(world, "own")).contains("never");
        assertThat(world.events()).isEmpty();
    }

    @Test
    void aFailureCostsOnlyItsItemAndIsReportedOnce() throws Exception {
        WorldDescription description =
                parse(
                        """
                        rules: {loud: {java: test.loud}}
                        items: [{name: throws}, {name: meddles}, {name: recurses}, {name: wrong}, {name: rex}]
                        """);
        World world = description.build(arena);
        Rules rules = new Rules(world, description.rules(), Rules.DEFAULT_STEPS);
        rules.update(1);
        rules.update(2);
        for (String item : List.of("throws", "meddles", "recurses", "wrong")) {
            assertThat(loud(world, item)).as(item).isEmpty();
        }
        assertThat(loud(world, "rex")).contains("REX");
        assertThat(world.find("meddles").orElseThrow().semantic().get("meddled")).isEmpty();
        assertThat(world.events()).extracting(WorldEvent::type).containsExactly("fault");
        assertThat(world.events().getFirst().fields())
                .containsEntry("source", "rule loud")
                .containsEntry("plugin", "the class path")
                .containsEntry("class", TestProviders.Loud.class.getName())
                .containsEntry("error", "IllegalStateException")
                .containsEntry("message", "out of order; throws has no loud (reported once)");
    }

    /** Ten steps for the call, one for the evaluation, and one for the visit of the item. */
    @Test
    void itsStepsCountInTheLimitOfRules() throws Exception {
        var items = new StringBuilder("rules: {loud: {java: test.loud}}\nitems:\n");
        for (int i = 0; i < 20; i++) {
            items.append("  - {name: dog").append(i).append("}\n");
        }
        WorldDescription description = parse(items.toString());
        World world = description.build(arena);
        Rules rules = new Rules(world, description.rules(), 60);
        rules.update(1); // the first update has a higher limit
        for (int i = 0; i < 20; i++) {
            world.find("dog" + i).orElseThrow().semantic().derive("loud", null);
        }
        rules.update(2);
        long computed = 0;
        for (int i = 0; i < 20; i++) {
            computed += loud(world, "dog" + i).isPresent() ? 1 : 0;
        }
        assertThat(computed).isBetween(5L, 6L);
    }

    @Test
    void aRuleInJavaIsWrittenAsItWasRead() throws Exception {
        WorldDescription world =
                parse("rules: {loud: {java: test.loud, class: dog, doc: Its name.}}\nitems: []\n");
        Rule rule = readAgain(world).rules().getFirst();
        assertThat(rule.symbol()).isEqualTo("loud");
        assertThat(rule.itemClass()).contains("dog");
        assertThat(rule.doc()).isEqualTo("Its name.");
        assertThat(((SymbolSource.Provided) rule.source()).provider().name())
                .isEqualTo("test.loud");
    }

    @Test
    void aSensorInJavaIsWrittenAsItWasRead() throws Exception {
        WorldDescription world =
                parse("items: [{name: a, sensors: {gps: {java: test.place, every: 3}}}]\n");
        Sensor sensor = world.items().getFirst().sensors().getFirst();
        assertThat(sensor.name()).isEqualTo("gps");
        assertThat(sensor.every()).isEqualTo(3);
        assertThat(sensor.sensesItems()).isFalse();
        assertThat(sensor.instrument().orElseThrow()).isInstanceOf(Instrument.Provided.class);
        Sensor again = readAgain(world).items().getFirst().sensors().getFirst();
        assertThat(again.name()).isEqualTo("gps");
        assertThat(again.every()).isEqualTo(3);
        assertThat(((Instrument.Provided) again.instrument().orElseThrow()).gauge().name())
                .isEqualTo("test.place");
    }

    @Test
    void aSensorThatNoPluginHasIsRefusedAtItsPlace() {
        assertThatThrownBy(() -> parse("items: [{name: a, sensors: {gps: {java: test.plaice}}}]\n"))
                .isInstanceOf(WorldFileException.class)
                .hasMessageContaining(
                        "w:3:41: java: there is no sensor `test.plaice`; the plugins have"
                                + " test.place; did you mean `test.place`?");
        assertThatThrownBy(
                        () ->
                                parse(
                                        "items: [{name: a, sensors: {gps: {java: test.place, range: 2}}}]\n"))
                .isInstanceOf(WorldFileException.class)
                .hasMessageContaining("range: a sensor with `java` only measures; leave it out");
    }
}
