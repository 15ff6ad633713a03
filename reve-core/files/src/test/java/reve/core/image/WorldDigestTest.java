// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.image.WorldDigest.Difference;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.Optional;
import java.util.Random;

class WorldDigestTest {

    private static final int ITEMS = 200;
    private static final long SEED = 20261121;

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final World other =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());

    @BeforeEach
    void fill() {
        for (World each : new World[] {world, other}) {
            Random random = new Random(SEED);
            for (int i = 0; i < ITEMS; i++) {
                each.add(
                        ItemDefinition.named("item " + i)
                                .at(random.nextGaussian(), random.nextGaussian(), 0)
                                .physics("mass", random.nextDouble())
                                .build());
            }
            each.remove(each.find("item 7").orElseThrow().id());
        }
    }

    @Test
    void equalWorldsHaveEqualNumbers() {
        assertThat(numbers(world)).isEqualTo(numbers(other));
        assertThat(new WorldDigest(other).firstDifference(numbers(world))).isEmpty();
    }

    @ParameterizedTest
    @ValueSource(strings = {"position", "velocity", "mass", "orientation", "size", "colour"})
    void theOnlyItemThatDiffersIsNamed(String property) {
        Random random = new Random(SEED);
        for (int i = 0; i < 50; i++) {
            Table bodies = other.table("body");
            Column column = bodies.column(property);
            int row = random.nextInt(bodies.rowCount());
            int component = random.nextInt(column.components());
            long bit = 1L << random.nextInt(8 * column.type().bytes());
            flip(column, row, component, bit);
            assertThat(new WorldDigest(other).firstDifference(numbers(world)))
                    .contains(new Difference("body", property, Optional.of(bodies.idAt(row))));
            flip(column, row, component, bit);
        }
        assertThat(numbers(world)).isEqualTo(numbers(other));
    }

    @Test
    void amongSeveralPropertiesTheOneThatNamesItsItemComesFirst() {
        other.items().stream()
                .filter(item -> item.kind().equals("body"))
                .forEach(item -> item.physical().setLocation(9, 9, 9));
        Item heavy = other.find("item 50").orElseThrow();
        heavy.physics().set("mass", 2);
        assertThat(new WorldDigest(other).firstDifference(numbers(world)))
                .contains(new Difference("body", "mass", Optional.of(heavy.id())));
        heavy.physics().set("mass", world.find("item 50").orElseThrow().physics().scalar("mass"));
        assertThat(new WorldDigest(other).firstDifference(numbers(world)))
                .contains(new Difference("body", "position", Optional.empty()));
    }

    @Test
    void anotherOrderOfRowsIsFound() {
        world.remove(world.find("item 3").orElseThrow().id());
        assertThat(new WorldDigest(other).firstDifference(numbers(world)))
                .contains(new Difference("body", WorldDigest.ROWS, Optional.empty()));
    }

    private static long[] numbers(World of) {
        var digest = new WorldDigest(of);
        long[] numbers = new long[digest.size()];
        digest.compute(numbers);
        return numbers;
    }

    private static void flip(Column column, int row, int component, long bit) {
        int at = row * column.components() + component;
        if (column.type().bytes() == Long.BYTES) {
            var values = column.buffer().asLongBuffer();
            values.put(at, values.get(at) ^ bit);
        } else {
            var values = column.buffer().asIntBuffer();
            values.put(at, values.get(at) ^ (int) bit);
        }
    }
}
