// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.Seed;

import java.util.ArrayList;
import java.util.List;
import java.util.Random;

class SymbolIndexTest {

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());

    @Test
    void findsStandardAndDesignersSymbols() {
        Item wheel = world.add(ItemDefinition.named("left").symbol("class", "wheel").build());
        Item other = world.add(ItemDefinition.named("right").symbol("class", "wheel").build());
        Item lamp =
                world.add(
                        ItemDefinition.named("lamp")
                                .symbol("lit", true)
                                .symbol("floor", 0)
                                .build());
        assertThat(world.withSymbol("class", "wheel")).containsExactly(wheel, other);
        assertThat(world.withSymbol("class", "body")).containsExactly(lamp);
        assertThat(world.withSymbol("class", "world")).hasSize(1);
        assertThat(world.withSymbol("lit", true)).containsExactly(lamp);
        assertThat(world.withSymbol("lit", "true")).isEmpty();
        assertThat(world.withSymbol("floor", -0.0)).containsExactly(lamp);
        assertThat(world.withSymbol("floor", 0L)).containsExactly(lamp);
        assertThat(world.withSymbol("name", "lamp")).containsExactly(lamp);
        assertThat(world.withSymbol("colour", "red")).isEmpty();
        world.rename(lamp.id(), "torch");
        assertThat(world.withSymbol("name", "lamp")).isEmpty();
        assertThat(world.withSymbol("name", "torch")).containsExactly(lamp);
    }

    @ParameterizedTest
    @ValueSource(longs = {31, 0})
    void agreesWithLookingThroughAllItems(long givenSeed) {
        long seed = Seed.of("symbols", givenSeed);
        Random random = new Random(seed);
        List<Item> items = new ArrayList<>();
        for (int step = 0; step < 2000; step++) {
            int what = items.isEmpty() ? 0 : random.nextInt(6);
            if (what < 2) {
                items.add(
                        world.add(
                                ItemDefinition.named("i" + step)
                                        .symbol("group", random.nextInt(4))
                                        .build()));
                continue;
            }
            Item item = items.get(random.nextInt(items.size()));
            switch (what) {
                case 2 -> item.semantic().set("group", random.nextInt(4));
                case 3 -> item.semantic().remove("group");
                case 4 -> item.semantic().set("class", "c" + random.nextInt(3));
                default -> {
                    world.remove(item.id());
                    items.remove(item);
                }
            }
            for (String symbol : List.of("group", "class")) {
                Object value = symbol.equals("group") ? random.nextInt(4) : "c" + random.nextInt(3);
                Object kept = value instanceof Integer number ? (double) number : value;
                assertThat(world.withSymbol(symbol, value))
                        .as("seed %d step %d", seed, step)
                        .containsExactlyElementsOf(
                                world.items().stream()
                                        .filter(
                                                each ->
                                                        each.semantic()
                                                                .get(symbol)
                                                                .filter(kept::equals)
                                                                .isPresent())
                                        .toList());
            }
        }
    }
}
