// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;

class WorldImageTest {

    private static final WorldPrototype PROTOTYPE = WorldPrototype.standard("si-f64");

    @ParameterizedTest(name = "seed {0}")
    @ValueSource(longs = {1, 2, 3, 4, 5})
    void worldsThatTookItOverGoOnAlike(long seed) {
        World world = empty();
        Random random = new Random(seed);
        change(world, random, 300);
        try (WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, 7);
            World other = empty();
            other.restore(image);
            assertThat(everything(other)).isEqualTo(everything(world));
            change(world, new Random(seed + 1), 300);
            change(other, new Random(seed + 1), 300);
            assertThat(everything(other)).isEqualTo(everything(world));

            world.restore(image);
            World third = empty();
            third.restore(image);
            assertThat(everything(world)).isEqualTo(everything(third));
            assertThat(image.frame()).isEqualTo(7);
        }
    }

    @Test
    void itemsKeepTheirObjectsAndWhatCameLaterCountsAsRemoved() {
        World world = empty();
        Item early = world.add(ItemDefinition.named("early").physics("mass", 2).build());
        Item stays = world.add(ItemDefinition.named("stays").build());
        try (WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, 0);
            Item late = world.add(ItemDefinition.named("late").physics("mass", 3).build());
            world.remove(early.id());

            world.restore(image);

            assertThat(world.find("early").orElseThrow().physics().scalar("mass")).isEqualTo(2);
            assertThat(world.find("stays")).containsSame(stays);
            assertThat(world.find("late")).isEmpty();
            assertThatIllegalStateException()
                    .isThrownBy(() -> late.physics().scalar("mass"))
                    .withMessageContaining("late");
        }
    }

    @Test
    void referencesAreCountedAgain() {
        World world = empty();
        world.addAll(
                List.of(
                        ItemDefinition.named("a").physics("mass", 1).build(),
                        ItemDefinition.named("b").physics("mass", 1).build(),
                        ItemDefinition.named("s")
                                .kind("spring")
                                .physics("length", 1)
                                .reference("end1", "a")
                                .reference("end2", "b")
                                .build()));
        try (WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, 0);
            World other = empty();
            other.restore(image);
            ItemId a = other.find("a").orElseThrow().id();
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> other.remove(a))
                    .withMessageContaining("item s");
            other.remove(other.find("s").orElseThrow().id());
            other.remove(a);
            assertThat(other.find("a")).isEmpty();
        }
    }

    @Test
    void anotherPrototypeIsRefusedByItsProperties() {
        World world = empty();
        World narrow = new World("test", WorldPrototype.standard("si-f32"), new OffHeapArena());
        try (WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, 0);
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> narrow.restore(image))
                    .withMessageContaining("kind body");
        }
    }

    private static World empty() {
        return new World("test", PROTOTYPE, new OffHeapArena());
    }

    /**
     * Adds, edits and removes items. The changes are the same if the world and the random numbers
     * are the same.
     */
    private static void change(World world, Random random, int times) {
        for (int i = 0; i < times; i++) {
            List<Item> items = world.items();
            Item any = items.get(random.nextInt(items.size()));
            FrameControl.of(world).placeAttached();
            switch (random.nextInt(9)) {
                case 0, 1 -> add(world, random);
                case 2 -> addSpring(world, random);
                case 3 -> {
                    if (!any.kind().equals("world")) {
                        world.removeCascade(any.id());
                    }
                }
                case 4 -> attach(world, random, any);
                case 5 -> {
                    if (any.parent().isPresent()) {
                        world.detach(any.id());
                    }
                }
                case 6 -> {
                    if (!any.kind().equals("world")) {
                        world.rename(any.id(), "renamed " + random.nextLong());
                    }
                }
                case 7 -> any.semantic().set("mood", random.nextDouble());
                default -> {
                    if (any.kind().equals("body")) {
                        any.physics()
                                .set("mass", any.parent().isPresent() ? 0 : random.nextDouble());
                        any.physical().setLocation(random.nextDouble(), 2, 3);
                    }
                }
            }
        }
    }

    /**
     * Attaches an item only to a younger body with no mass. Therefore no two items can move with
     * each other.
     */
    private static void attach(World world, Random random, Item parent) {
        List<Item> younger =
                world.items().stream()
                        .filter(
                                item ->
                                        item.kind().equals("body")
                                                && item.physics().isEmpty()
                                                && item.id().compareTo(parent.id()) > 0)
                        .toList();
        if (parent.kind().equals("body") && !younger.isEmpty()) {
            world.attach(younger.get(random.nextInt(younger.size())).id(), parent.id());
        }
    }

    private static void add(World world, Random random) {
        var item =
                ItemDefinition.named("item " + random.nextLong())
                        .at(random.nextDouble(), random.nextDouble(), 0)
                        .shape(Shape.sphere(1));
        world.add(
                random.nextBoolean()
                        ? item.physics("mass", random.nextDouble()).build()
                        : item.build());
    }

    private static void addSpring(World world, Random random) {
        List<Item> bodies =
                world.items().stream()
                        .filter(item -> item.kind().equals("body") && !item.physics().isEmpty())
                        .toList();
        if (!bodies.isEmpty()) {
            world.add(
                    ItemDefinition.named("spring " + random.nextLong())
                            .kind("spring")
                            .physics("length", random.nextDouble())
                            .reference("end1", bodies.get(random.nextInt(bodies.size())).name())
                            .reference("end2", bodies.get(random.nextInt(bodies.size())).name())
                            .build());
        }
    }

    /**
     * Returns the complete state, which has the rows in their order with their bits, the symbols,
     * and the next id.
     */
    private static Map<String, Object> everything(World world) {
        Map<String, Object> all = new LinkedHashMap<>();
        all.put("symbols", Map.copyOf(world.symbols()));
        all.put("items", world.items().stream().map(Item::toString).toList());
        all.put("last id", world.lastId());
        for (Table table : world.tables()) {
            all.put(table.kind(), table.physicsRowCount());
            List<String> named = new ArrayList<>();
            for (int row = 0; row < table.rowCount(); row++) {
                named.add(world.item(table.idAt(row)).name());
            }
            all.put(table.kind() + " rows", named);
            table.allColumns()
                    .forEach(
                            column ->
                                    all.put(
                                            table.kind() + "." + column.name(),
                                            HexFormat.of()
                                                    .formatHex(
                                                            column.segment()
                                                                    .toArray(
                                                                            ValueLayout
                                                                                    .JAVA_BYTE))));
        }
        return all;
    }
}
