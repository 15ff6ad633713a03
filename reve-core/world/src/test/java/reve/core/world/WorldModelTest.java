// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.Set;
import java.util.stream.Collectors;

/** Long random histories of a world, compared with plain hash maps after every step. */
class WorldModelTest {

    /** The state of an item in the oracle. */
    private static final class Expected {
        private final long id;
        private final String kind;
        private boolean physics;
        private double[] location = {0, 0, 0};
        private final Map<String, double[]> numbers = new HashMap<>();
        private final Map<String, String> references = new HashMap<>();

        Expected(long id, String kind) {
            this.id = id;
            this.kind = kind;
        }
    }

    private final Map<String, Expected> oracle = new LinkedHashMap<>();
    private Random random = new Random();
    private World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private int named;

    @ParameterizedTest
    @CsvSource({"si-f64, 11", "si-f32, 12", "si-f64, 0", "si-f32, 0"})
    void agreesWithPlainMapsThroughRandomHistories(String prototype, long givenSeed) {
        long seed = Seed.of("histories in " + prototype, givenSeed);
        random = new Random(seed);
        world = new World("w", WorldPrototype.standard(prototype), new OffHeapArena());
        for (int step = 0; step < 1500; step++) {
            change();
            if (step % 50 == 0) {
                FrameControl.of(world).endPhysics();
            }
            if (step % 7 == 0) {
                check("seed " + seed + " step " + step);
            }
        }
        check("seed " + seed + " end");
    }

    private void change() {
        switch (random.nextInt(12)) {
            case 0, 1, 2 -> addBody(true);
            case 3 -> addBody(false);
            case 4 -> addSpring();
            case 5, 6 -> edit();
            case 7 -> remove();
            case 8 -> removeCascade();
            case 9 -> rename();
            case 10 -> clear();
            default -> redirect();
        }
    }

    private void addBody(boolean physics) {
        String name = "body" + named++;
        double[] at = triple();
        var definition = ItemDefinition.named(name).at(at[0], at[1], at[2]);
        double[] velocity = triple();
        if (physics) {
            definition.physics("velocity", velocity);
        }
        Item item = world.add(definition.build());
        Expected expected = new Expected(item.id().value(), "body");
        expected.location = at;
        expected.physics = physics;
        if (physics) {
            expected.numbers.put("velocity", velocity);
        }
        oracle.put(name, expected);
    }

    private void addSpring() {
        List<String> ends = names("body", true);
        if (ends.isEmpty()) {
            return;
        }
        String name = "spring" + named++;
        String end1 = pick(ends);
        String end2 = pick(ends);
        Item item =
                world.add(
                        ItemDefinition.named(name)
                                .kind("spring")
                                .reference("end1", end1)
                                .reference("end2", end2)
                                .physics("length", 3)
                                .build());
        Expected expected = new Expected(item.id().value(), "spring");
        expected.physics = true;
        expected.numbers.put("length", new double[] {3});
        expected.references.put("end1", end1);
        expected.references.put("end2", end2);
        oracle.put(name, expected);
    }

    private void edit() {
        List<String> bodies = new ArrayList<>(names("body", true));
        bodies.addAll(names("body", false));
        if (bodies.isEmpty()) {
            return;
        }
        String name = pick(bodies);
        Expected expected = oracle.get(name);
        Item item = world.find(name).orElseThrow();
        double[] value = triple();
        if (random.nextBoolean()) {
            item.physical().setLocation(value[0], value[1], value[2]);
            expected.location = value;
        } else {
            item.physics().set("externalForce", value);
            if (!expected.physics) {
                expected.numbers.put("velocity", new double[3]);
            }
            expected.numbers.put("externalForce", value);
            expected.physics = true;
        }
    }

    private void remove() {
        if (oracle.isEmpty()) {
            return;
        }
        String name = pick(List.copyOf(oracle.keySet()));
        ItemId id = world.find(name).orElseThrow().id();
        if (referring(Set.of(name)).isEmpty()) {
            world.remove(id);
            oracle.remove(name);
        } else {
            assertThatIllegalArgumentException().isThrownBy(() -> world.remove(id));
        }
    }

    private void removeCascade() {
        if (oracle.isEmpty()) {
            return;
        }
        String name = pick(List.copyOf(oracle.keySet()));
        world.removeCascade(world.find(name).orElseThrow().id());
        oracle.keySet().removeAll(referring(Set.of(name)));
        oracle.remove(name);
    }

    private void rename() {
        if (oracle.isEmpty()) {
            return;
        }
        String name = pick(List.copyOf(oracle.keySet()));
        String newName = "item" + named++;
        world.rename(world.find(name).orElseThrow().id(), newName);
        Map<String, Expected> before = new LinkedHashMap<>(oracle);
        oracle.clear();
        before.forEach(
                (key, expected) -> {
                    expected.references.replaceAll(
                            (property, to) -> to.equals(name) ? newName : to);
                    oracle.put(key.equals(name) ? newName : key, expected);
                });
    }

    private void clear() {
        List<String> bodies = names("body", true);
        if (bodies.isEmpty()) {
            return;
        }
        String name = pick(bodies);
        Item item = world.find(name).orElseThrow();
        if (referring(Set.of(name)).isEmpty()) {
            item.physics().clear();
            oracle.get(name).physics = false;
            oracle.get(name).numbers.clear();
        } else {
            assertThatIllegalArgumentException()
                    .isThrownBy(item.physics()::clear)
                    .withMessageContaining("cannot become scenery");
        }
    }

    private void redirect() {
        List<String> springs = names("spring", true);
        if (springs.isEmpty()) {
            return;
        }
        String spring = pick(springs);
        String target = pick(names("body", true));
        world.find(spring)
                .orElseThrow()
                .physics()
                .setReferences("end1", world.find(target).orElseThrow().id());
        oracle.get(spring).references.put("end1", target);
    }

    private void check(String when) {
        assertThat(world.items())
                .as(when)
                .extracting(Item::name)
                .containsExactlyElementsOf(concat("world", oracle.keySet()));
        assertThat(world.symbols().values())
                .as(when)
                .extracting(ItemSymbols::name)
                .containsExactlyElementsOf(concat("world", oracle.keySet()));
        for (String kind : List.of("body", "spring")) {
            Table table = world.table(kind);
            assertThat(table.rowCount())
                    .as(when)
                    .isEqualTo(names(kind, true).size() + names(kind, false).size());
            assertThat(table.physicsRowCount()).as(when).isEqualTo(names(kind, true).size());
            for (int row = 0; row < table.rowCount(); row++) {
                assertThat(table.rowOf(table.idAt(row))).as(when).isEqualTo(row);
            }
        }
        oracle.forEach((name, expected) -> checkItem(when + " " + name, name, expected));
    }

    private void checkItem(String when, String name, Expected expected) {
        Item item = world.find(name).orElseThrow();
        assertThat(item.id().value()).as(when).isEqualTo(expected.id);
        assertThat(item.kind()).as(when).isEqualTo(expected.kind);
        assertThat(item.physics().isEmpty()).as(when).isEqualTo(!expected.physics);
        int row = world.table(expected.kind).rowOf(item.id());
        assertThat(row < world.table(expected.kind).physicsRowCount())
                .as(when)
                .isEqualTo(expected.physics);
        if (expected.kind.equals("body")) {
            assertThat(item.physical().location()).as(when).containsExactly(expected.location);
        }
        expected.numbers.forEach(
                (property, value) ->
                        assertThat(item.physics().vector(property))
                                .as(when)
                                .containsExactly(value));
        expected.references.forEach(
                (property, target) ->
                        assertThat(item.physics().reference(property).value())
                                .as(when)
                                .isEqualTo(oracle.get(target).id));
    }

    private List<String> names(String kind, boolean physics) {
        return oracle.entrySet().stream()
                .filter(entry -> entry.getValue().kind.equals(kind))
                .filter(entry -> entry.getValue().physics == physics)
                .map(Map.Entry::getKey)
                .toList();
    }

    private Set<String> referring(Set<String> targets) {
        return oracle.entrySet().stream()
                .filter(
                        entry ->
                                entry.getValue().references.values().stream()
                                        .anyMatch(targets::contains))
                .map(Map.Entry::getKey)
                .collect(Collectors.toSet());
    }

    /** Returns numbers that both real types represent exactly. */
    private double[] triple() {
        return random.ints(3, -1000, 1000).mapToDouble(i -> i / 8.0).toArray();
    }

    private String pick(List<String> from) {
        return from.get(random.nextInt(from.size()));
    }

    private static List<String> concat(String first, Set<String> rest) {
        List<String> all = new ArrayList<>(List.of(first));
        all.addAll(rest);
        return all;
    }
}
