// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.concurrent.atomic.AtomicInteger;

class WorldStructureTest {

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", WorldPrototype.standard("si-f64"), arena);

    @AfterEach
    void closeArena() {
        arena.close();
    }

    private Item ball(String name) {
        return world.add(ItemDefinition.named(name).physics("mass", 1).build());
    }

    private ItemDefinition spring(String name, String end1, String end2) {
        return ItemDefinition.named(name)
                .kind("spring")
                .physics("springConstant", 100)
                .reference("end1", end1)
                .reference("end2", end2)
                .build();
    }

    @Test
    void aNewWorldHoldsOneItemForItsConstants() {
        assertThat(world.items())
                .singleElement()
                .satisfies(
                        constants -> {
                            assertThat(constants.name()).isEqualTo("world");
                            assertThat(constants.kind()).isEqualTo("world");
                            constants.physics().set("gravity", 0, -9.81, 0);
                            assertThat(constants.physics().vector("gravity"))
                                    .containsExactly(0, -9.81, 0);
                        });
        assertThat(world.table("world").physicsRowCount()).isEqualTo(1);
    }

    @Test
    void theItemAndTheKindOfTheConstantsAreReserved() {
        Item constants = world.find("world").orElseThrow();
        assertThatIllegalArgumentException().isThrownBy(() -> world.remove(constants.id()));
        assertThatIllegalArgumentException().isThrownBy(() -> world.removeCascade(constants.id()));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.add(ItemDefinition.named("world").build()))
                .withMessageContaining("reserved");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.add(ItemDefinition.named("two").kind("world").build()))
                .withMessageContaining("exactly one");
        assertThat(world.items()).containsExactly(constants);
    }

    @Test
    void addRejectsDuplicateNamesInTheWorldAndInTheBatch() {
        ball("red");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball("red"))
                .withMessage("item name red is already taken");
        ItemDefinition blue = ItemDefinition.named("blue").build();
        assertThatIllegalArgumentException().isThrownBy(() -> world.addAll(List.of(blue, blue)));
        assertThat(world.find("blue")).isEmpty();
    }

    @Test
    void aRefusedBatchChangesNothing() {
        long layout = world.layoutVersion();
        var symbols = world.symbols();
        var good = ItemDefinition.named("good").physics("mass", 1).build();
        var refused =
                List.of(
                        ItemDefinition.named("bad").physics("mas", 1).build(),
                        ItemDefinition.named("bad").physics("velocity", 1).build(),
                        ItemDefinition.named("bad").kind("ghost").build(),
                        ItemDefinition.named("bad").physics("end1", 1).build(),
                        ItemDefinition.named("bad").reference("mass", "good").build(),
                        spring("bad", "good", "nobody"),
                        spring("bad", "good", "bad"),
                        ItemDefinition.named("bad")
                                .kind("spring")
                                .reference("end1", "good")
                                .build(),
                        ItemDefinition.named("bad")
                                .kind("spring")
                                .reference("end1", "good", "good")
                                .reference("end2", "good")
                                .build());
        for (ItemDefinition bad : refused) {
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> world.addAll(List.of(good, bad)))
                    .withMessageMatching(".*(bad|ghost).*");
        }
        assertThat(world.layoutVersion()).isEqualTo(layout);
        assertThat(world.symbols()).isSameAs(symbols);
        assertThat(world.items()).hasSize(1);
    }

    @Test
    void itemsOfABatchMayReferToEachOtherInAnyOrder() {
        List<Item> added =
                world.addAll(
                        List.of(
                                spring("s", "a", "b"),
                                ItemDefinition.named("b").physics("mass", 1).build(),
                                ItemDefinition.named("a").physics("mass", 1).build()));
        assertThat(added.get(0).physics().reference("end1")).isEqualTo(added.get(2).id());
        assertThat(added.get(0).physics().reference("end2")).isEqualTo(added.get(1).id());
    }

    @Test
    void referencesPointAtItemsOfTheRightKindWithPhysics() {
        ball("a");
        ball("b");
        world.add(ItemDefinition.named("lamp").build());
        world.add(spring("s", "a", "b"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.add(spring("t", "a", "lamp")))
                .withMessageContaining("item t: end2 refers to lamp, which is scenery");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.add(spring("t", "a", "s")))
                .withMessageContaining("end2 refers to s of kind spring, expected kind body");
        Item spring = world.find("s").orElseThrow();
        Item lamp = world.find("lamp").orElseThrow();
        assertThatIllegalArgumentException()
                .isThrownBy(() -> spring.physics().setReferences("end2", lamp.id()));
        lamp.physics().set("mass", 0);
        spring.physics().setReferences("end2", lamp.id());
        assertThat(spring.physics().reference("end2")).isEqualTo(lamp.id());
        world.remove(world.find("b").orElseThrow().id());
        assertThatIllegalArgumentException().isThrownBy(() -> world.remove(lamp.id()));
    }

    @Test
    void sceneryOfAKindWithReferencesCannotBecomePhysicalWithoutThem() {
        Item inert = world.add(ItemDefinition.named("s").kind("spring").build());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> inert.physics().set("springConstant", 1))
                .withMessageContaining("end1");
        assertThat(inert.physics().isEmpty()).isTrue();
    }

    @Test
    void removingIsRefusedWhileReferredToAndNamesWho() {
        Item a = ball("a");
        ball("b");
        Item s = world.add(spring("s", "a", "b"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.remove(a.id()))
                .withMessageContaining("item a")
                .withMessageContaining("item s");
        world.remove(s.id());
        world.remove(a.id());
        assertThat(world.items()).extracting(Item::name).containsExactly("world", "b");
    }

    @Test
    void cascadeRemovesWhoRefersAndNobodyElse() {
        Item a = ball("a");
        ball("b");
        ball("c");
        ball("d");
        world.addAll(
                List.of(
                        spring("ab", "a", "b"),
                        spring("ca", "c", "a"),
                        spring("bc", "b", "c"),
                        ItemDefinition.named("f")
                                .kind("surface")
                                .reference("vertices", "a", "b", "c")
                                .build()));
        world.removeCascade(a.id());
        assertThat(world.items())
                .extracting(Item::name)
                .containsExactly("world", "b", "c", "d", "bc");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.remove(world.find("b").orElseThrow().id()));
        world.remove(world.find("d").orElseThrow().id());
    }

    @Test
    void unknownItemsAndKindsAreNamed() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.item(new ItemId(99)))
                .withMessageContaining("#99");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.table("ghost"))
                .withMessageContaining("ghost")
                .withMessageContaining("body, spring");
        assertThat(world.find("nobody")).isEmpty();
        assertThat(world.table("body").rowOf(new ItemId(1))).isEqualTo(-1);
    }

    @Test
    void structureIsLockedByPhaseButValuesAreNot() {
        Item a = ball("a");
        Item lamp = world.add(ItemDefinition.named("lamp").build());
        FrameControl.of(world).lock("PHYSICS");
        for (Runnable change :
                List.<Runnable>of(
                        () -> ball("b"),
                        () -> world.remove(a.id()),
                        () -> world.removeCascade(a.id()),
                        () -> lamp.physics().set("mass", 1))) {
            assertThatIllegalStateException()
                    .isThrownBy(change::run)
                    .withMessageContaining("PHYSICS")
                    .withMessageContaining("test");
        }
        a.physics().set("mass", 2);
        lamp.physical().setLocation(1, 2, 3);
        FrameControl.of(world).unlock();
        lamp.physics().set("mass", 1);
        assertThat(world.table("body").physicsRowCount()).isEqualTo(2);
    }

    @Test
    void replacedMemoryStaysReadableUntilItIsReleased() {
        ball("first").physics().set("mass", 42);
        MemorySegment before = world.table("body").column("mass").segment();
        for (int i = 0; i < 64; i++) {
            ball("b" + i);
        }
        MemorySegment after = world.table("body").column("mass").segment();
        assertThat(after.address()).isNotEqualTo(before.address());
        assertThat(before.get(ColumnView.DOUBLE, 0)).isEqualTo(42);
        assertThat(after.get(ColumnView.DOUBLE, 0)).isEqualTo(42);
        FrameControl.of(world).endPhysics();
        assertThat(before.scope().isAlive()).isFalse();
        assertThat(after.scope().isAlive()).isTrue();
    }

    @Test
    void layoutVersionRisesExactlyWhenRowsOrMemoryChange() {
        long start = world.layoutVersion();
        Item a = ball("a");
        assertThat(world.layoutVersion()).isGreaterThan(start);
        long afterAdd = world.layoutVersion();
        a.physics().set("mass", 2);
        a.physical().setShape(Shape.sphere(1));
        a.semantic().set("lit", true);
        assertThat(world.layoutVersion()).isEqualTo(afterAdd);
        world.remove(a.id());
        assertThat(world.layoutVersion()).isGreaterThan(afterAdd);
    }

    @Test
    void columnMemoryPerItemStaysUnderHalfAKibibyteWhateverTheNumberOfItems() {
        var counting = new CountingArena();
        World big = new World("big", WorldPrototype.standard("si-f64"), counting);
        long empty = counting.bytes;
        for (int i = 0; i < 5000; i++) {
            big.add(ItemDefinition.named("b" + i).physics("mass", 1).build());
        }
        FrameControl.of(big).endPhysics();
        long capacity = 8192;
        assertThat((counting.bytes - empty) / capacity).isLessThan(512);
    }

    @Test
    void anotherThreadIsRefusedUntilItClaimsTheWorld() throws InterruptedException {
        assertThat(Boolean.getBoolean("reve.check.thread")).as("tests run checked").isTrue();
        Item a = ball("a");
        List<Runnable> uses =
                List.of(
                        () -> world.find("a"),
                        () -> world.items(),
                        () -> ball("b"),
                        () -> a.physics().scalar("mass"),
                        () -> a.physical().setLocation(0, 0, 0),
                        () -> a.semantic().set("x", 1),
                        () -> world.raise(new WorldEvent(1, "acted", Map.of())));
        var refused = new AtomicInteger();
        Thread other =
                new Thread(
                        () -> {
                            for (Runnable use : uses) {
                                try {
                                    use.run();
                                } catch (IllegalStateException e) {
                                    refused.addAndGet(e.getMessage().contains("intruder") ? 1 : 0);
                                }
                            }
                            world.guard().claim();
                            a.physics().set("mass", 3);
                        },
                        "intruder");
        other.start();
        other.join();
        assertThat(refused).hasValue(uses.size());
        assertThatIllegalStateException()
                .isThrownBy(() -> world.find("a"))
                .withMessageContaining("belongs to thread intruder");
        world.guard().claim();
        assertThat(a.physics().scalar("mass")).isEqualTo(3);
    }

    @Test
    void aWorldHasANameThatCanBePartOfAFileName() {
        WorldPrototype prototype = WorldPrototype.standard("si-f64");
        for (String name : List.of("w", "2 Balls_v1.0-b", "x".repeat(128))) {
            assertThat(new World(name, prototype, arena).name()).isEqualTo(name);
        }
        for (String name : List.of("", "..", "a/b", "../a", " a", "é", "a\n", "x".repeat(129))) {
            assertThatIllegalArgumentException()
                    .as(name)
                    .isThrownBy(() -> new World(name, prototype, arena))
                    .withMessageContaining("world name");
        }
    }

    @Test
    void anArenaThatIsFullLeavesTheWorldAsItWas() {
        var limited = new CountingArena();
        World small = new World("small", WorldPrototype.standard("si-f64"), limited);
        small.add(ItemDefinition.named("first").physics("mass", 5).build());
        limited.limit = limited.bytes + 10_000;
        long layout = small.layoutVersion();
        List<ItemDefinition> many = new ArrayList<>();
        for (int i = 0; i < 200; i++) {
            many.add(ItemDefinition.named("b" + i).physics("mass", i).build());
        }
        assertThatIllegalStateException()
                .isThrownBy(() -> small.addAll(many))
                .withMessageContaining("full");
        assertThat(small.items()).hasSize(2);
        assertThat(small.table("body").rowCount()).isEqualTo(1);
        assertThat(small.layoutVersion()).as("some columns moved").isGreaterThan(layout);
        limited.limit = Long.MAX_VALUE;
        List<Item> added = small.addAll(many);
        assertThat(small.find("first").orElseThrow().physics().scalar("mass")).isEqualTo(5);
        assertThat(added.get(199).physics().scalar("mass")).isEqualTo(199);
    }

    private static final class CountingArena implements ColumnArena {
        private final OffHeapArena memory = new OffHeapArena();
        private long bytes;
        private long limit = Long.MAX_VALUE;

        @Override
        public MemorySegment reserve(String name, long size) {
            if (bytes + size > limit) {
                throw new IllegalStateException("arena is full: no room for " + name);
            }
            bytes += size;
            return memory.reserve(name, size);
        }

        @Override
        public void release(MemorySegment segment) {
            bytes -= segment.byteSize();
            memory.release(segment);
        }

        @Override
        public void close() {
            memory.close();
        }
    }
}
