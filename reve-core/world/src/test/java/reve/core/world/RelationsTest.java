// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.derive.BoundingBoxes;

import java.util.ArrayList;
import java.util.List;
import java.util.Random;

class RelationsTest {
    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", WorldPrototype.standard("si-f64"), arena);

    @AfterEach
    void free() {
        arena.close();
    }

    private Item box(String name, double size, double x, double y, double z) {
        return world.add(
                ItemDefinition.named(name).shape(Shape.box(size, size, size)).at(x, y, z).build());
    }

    private void derive() {
        new BoundingBoxes().update(world);
    }

    private static Object of(Item item, String relation) {
        return item.semantic().get(relation).orElse("none");
    }

    @Test
    void aCupOnATableInARoom() {
        Item room = box("room", 10, 0, 5, 0);
        Item table = box("table", 1, 0, 0.5, 0);
        Item cup = box("cup", 0.1, 0.2, 1.05, 0);
        Item lamp = box("lamp", 0.2, 0.75, 1.5, 0);
        derive();

        assertThat(of(cup, "on")).isEqualTo(List.of("table"));
        assertThat(of(cup, "inside")).isEqualTo(List.of("room"));
        assertThat(of(cup, "touching")).isEqualTo(List.of("room", "table"));
        assertThat(of(table, "on")).isEqualTo(List.of());
        assertThat(of(table, "inside")).isEqualTo(List.of("room"));
        assertThat(of(table, "touching")).isEqualTo(List.of("room", "cup"));
        assertThat(of(lamp, "near")).isEqualTo(List.of("room"));
        assertThat(of(room, "inside")).isEqualTo(List.of());

        lamp.physical().setLocation(0.45, 1.2, 0);
        derive();
        assertThat(of(lamp, "near")).isEqualTo(List.of("room", "table", "cup"));
    }

    @Test
    void toleranceIsAHundredthOfTheSmallerDiagonal() {
        double diagonal = Math.sqrt(3);
        Item low = box("low", 1, 0, 0, 0);
        Item high = box("high", 1, 0, 1 + 0.0099 * diagonal, 0);
        derive();
        assertThat(of(high, "on")).isEqualTo(List.of("low"));
        assertThat(of(low, "touching")).isEqualTo(List.of("high"));

        high.physical().setLocation(0, 1 + 0.0101 * diagonal, 0);
        derive();
        assertThat(of(high, "on")).isEqualTo(List.of());
        assertThat(of(low, "touching")).isEqualTo(List.of());
        assertThat(of(low, "near")).isEqualTo(List.of("high"));

        high.physical().setLocation(0, 1 + 1.01 * diagonal, 0);
        derive();
        assertThat(of(low, "near")).isEqualTo(List.of());
    }

    @Test
    void onlyBodiesWithAShapeAreRelated() {
        Item point = world.add(ItemDefinition.named("point").at(0, 0, 0).build());
        Item box = box("box", 1, 0, 0, 0);
        Item load = world.add(ItemDefinition.named("load").physics("mass", 1).build());
        derive();

        assertThat(of(point, "near")).isEqualTo("none");
        assertThat(of(load, "near")).isEqualTo("none");
        assertThat(of(box, "near")).isEqualTo(List.of());
    }

    @Test
    void itemsOfOneSizeAndPlaceAreNotInsideEachOther() {
        Item one = box("one", 1, 0, 0, 0);
        Item two = box("two", 1, 0, 0, 0);
        derive();

        assertThat(of(one, "inside")).isEqualTo(List.of());
        assertThat(of(two, "touching")).isEqualTo(List.of("one"));
    }

    @Test
    void nearestComeFirstAndThereAreNoMoreThanTheLimit() {
        Item middle = box("middle", 1, 0, 0, 0);
        for (int i = 0; i < 40; i++) {
            box("b" + i, 1, 1.5 - 0.01 * i, 0, 0);
        }
        derive();

        assertThat((List<?>) of(middle, "near"))
                .hasSize(Relations.MAX_ITEMS)
                .first()
                .isEqualTo("b39");
    }

    @Test
    void inACrowdAtOnePlaceTheFirstByIdComeFirst() {
        box("aside", 1, 1.2, 0, 0);
        var crowd = new ArrayList<Item>();
        for (int i = 0; i < 100; i++) {
            crowd.add(box("one-" + i, 1, 0.001 * i, 0, 0));
        }
        derive();
        List<String> first =
                crowd.stream().skip(1).limit(Relations.MAX_ITEMS).map(Item::name).toList();
        assertThat(of(crowd.getFirst(), "near")).isEqualTo(first);
        assertThat(of(crowd.getFirst(), "touching")).isEqualTo(first);
        assertThat((List<?>) of(crowd.getLast(), "near"))
                .hasSize(Relations.MAX_ITEMS)
                .first()
                .isEqualTo("one-0");
    }

    @Test
    void theyAreAskedForByTheirNames() {
        Item one = box("one", 1, 0, 0, 0);
        derive();
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.relations().of(one.id(), "above"))
                .withMessageContaining("above")
                .withMessageContaining("touching");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> one.semantic().set("near", "x"))
                .withMessageContaining("derives");
    }

    @Test
    void indexFindsWhatAComparisonOfAllPairsFinds() {
        long seed = Seed.of("relations");
        var random = new Random(seed);
        List<Item> items = new ArrayList<>();
        for (int i = 0; i < 60; i++) {
            items.add(
                    box(
                            "i" + i,
                            Math.exp(random.nextDouble() * 3 - 2),
                            random.nextInt(8),
                            0.5 * random.nextInt(4),
                            random.nextInt(8)));
        }
        derive();
        for (Item item : items) {
            List<String> near = new ArrayList<>();
            for (Item other : items) {
                if (other != item
                        && gap(item, other) <= Math.min(diagonal(item), diagonal(other))) {
                    near.add(other.name());
                }
            }
            List<?> found = (List<?>) of(item, "near");
            assertThat(near)
                    .as("seed %d, %s", seed, item)
                    .containsAll(List.copyOf(found).stream().map(Object::toString).toList());
            assertThat(found).hasSize(Math.min(near.size(), Relations.MAX_ITEMS));
        }
    }

    private static double gap(Item a, Item b) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            double apart =
                    Math.abs(a.physical().location()[axis] - b.physical().location()[axis])
                            - (a.physical().size()[axis] + b.physical().size()[axis]) / 2;
            sum += Math.max(0, apart) * Math.max(0, apart);
        }
        return Math.sqrt(sum);
    }

    private static double diagonal(Item item) {
        return item.physical().size()[0] * Math.sqrt(3);
    }
}
