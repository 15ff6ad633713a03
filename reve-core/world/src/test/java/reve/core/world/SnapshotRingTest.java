// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.Seed;

import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.atomic.AtomicBoolean;

class SnapshotRingTest {

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());

    private Item ball(String name) {
        return world.add(ItemDefinition.named(name).physics("mass", 1).build());
    }

    @Test
    void thereIsNothingToReadBeforeTheFirstFrame() {
        assertThat(new SnapshotRing(world, 2).acquireLatest()).isEmpty();
        assertThatIllegalArgumentException().isThrownBy(() -> new SnapshotRing(world, 1));
    }

    @Test
    void aSnapshotKeepsWhatWasPublishedWhileTheWorldGoesOn() {
        var ring = new SnapshotRing(world, 3);
        Item red =
                world.add(
                        ItemDefinition.named("red")
                                .at(1, 2, 3)
                                .symbol("lit", true)
                                .physics("mass", 5)
                                .build());
        world.raise(new WorldEvent(7, "joined", Map.of("agent", "ada")));
        ring.publish(7, 0.25);
        red.physical().setLocation(9, 9, 9);
        red.semantic().set("lit", false);
        ball("late");
        FrameControl.of(world).end();

        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            TableSnapshot body = snapshot.table("body");
            assertThat(snapshot.frame()).isEqualTo(7);
            assertThat(snapshot.timeSeconds()).isEqualTo(0.25);
            assertThat(body.rowCount()).isEqualTo(1);
            assertThat(body.idAt(0)).isEqualTo(red.id());
            assertThat(body.rowOf(red.id())).isZero();
            assertThat(body.rowOf(new ItemId(99))).isEqualTo(-1);
            assertThat(body.column("position").getDouble(0, 2)).isEqualTo(3);
            assertThat(body.column("mass").getDouble(0, 0)).isEqualTo(5);
            assertThat(snapshot.symbols()).hasSize(2);
            assertThat(snapshot.symbols().get(red.id()).get("lit")).contains(true);
            assertThat(snapshot.events()).extracting(WorldEvent::type).containsExactly("joined");
            assertThat(snapshot.lost()).isFalse();
        }
        ring.publish(8, 0.5);
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            assertThat(snapshot.events()).isEmpty();
            assertThat(snapshot.table("body").rowCount()).isEqualTo(2);
        }
    }

    @Test
    void columnsOfASnapshotAreReadOnlyAndComplete() {
        ball("red");
        var ring = new SnapshotRing(world, 2);
        ring.publish(1, 0);
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            TableSnapshot body = snapshot.table("body");
            assertThat(body.columns())
                    .extracting(ColumnView::name)
                    .containsExactlyElementsOf(
                            world.table("body").columns().stream().map(ColumnView::name).toList());
            var segment = body.column("mass").segment();
            assertThat(segment.byteSize()).isEqualTo(8);
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> segment.set(ValueLayout.JAVA_DOUBLE, 0, 2));
            assertThatIllegalArgumentException().isThrownBy(() -> body.column("mas"));
        }
    }

    @Test
    void framesShareTheColumnsThatDidNotChange() {
        ball("red").physics().set("mass", 5);
        var ring = new SnapshotRing(world, 3);
        ring.publish(1, 0);
        WorldSnapshot first = ring.acquireLatest().orElseThrow();
        world.find("red").orElseThrow().physics().set("mass", 6);
        ring.publish(2, 0);
        WorldSnapshot second = ring.acquireLatest().orElseThrow();
        assertThat(address(second, "position")).isEqualTo(address(first, "position"));
        assertThat(address(second, "torque")).as("zeros").isEqualTo(address(second, "charge"));
        assertThat(address(second, "mass")).isNotEqualTo(address(first, "mass"));
        assertThat(first.table("body").column("mass").getDouble(0, 0)).isEqualTo(5);
        first.close();
        second.close();
    }

    private static long address(WorldSnapshot snapshot, String property) {
        return snapshot.table("body").column(property).segment().address();
    }

    /**
     * A snapshot that is not lost always equals its frame, even if it shares memory with other
     * snapshots.
     */
    @ParameterizedTest
    @ValueSource(longs = {61, 0})
    void heldSnapshotsStayAsTheyWere(long givenSeed) {
        long seed = Seed.of("held snapshots", givenSeed);
        Random random = new Random(seed);
        var ring = new SnapshotRing(world, 4);
        List<WorldSnapshot> held = new ArrayList<>();
        List<String> then = new ArrayList<>();
        for (int i = 0; i < 20; i++) {
            ball("first" + i);
        }
        for (int frame = 1; frame < 500; frame++) {
            Item item = world.items().get(1 + random.nextInt(20));
            switch (random.nextInt(5)) {
                case 0 -> item.physics().set("mass", random.nextInt(3));
                case 1 -> item.physics().set("charge", random.nextInt(2));
                case 2 -> item.physical().setLocation(random.nextInt(2), 0, 0);
                case 3 -> {
                    world.remove(item.id());
                    ball("ball" + frame);
                }
                default -> {}
            }
            ring.publish(frame, 0);
            WorldSnapshot latest = ring.acquireLatest().orElseThrow();
            held.add(latest);
            then.add(text(latest));
            if (random.nextInt(3) > 0) {
                int gone = random.nextInt(held.size());
                held.remove(gone).close();
                then.remove(gone);
            }
            for (int i = held.size() - 1; i >= 0; i--) {
                if (held.get(i).lost()) {
                    held.remove(i).close();
                    then.remove(i);
                } else {
                    assertThat(text(held.get(i)))
                            .as("seed %d frame %d", seed, frame)
                            .isEqualTo(then.get(i));
                }
            }
        }
        held.forEach(WorldSnapshot::close);
    }

    private static String text(WorldSnapshot snapshot) {
        var text = new StringBuilder();
        TableSnapshot bodies = snapshot.table("body");
        for (int row = 0; row < bodies.rowCount(); row++) {
            text.append(bodies.idAt(row));
            for (String property : List.of("mass", "charge", "position", "orientation")) {
                text.append(' ').append(bodies.column(property).getDouble(row, 0));
            }
        }
        return text.toString();
    }

    @Test
    void publishingGoesAroundASlotThatIsBeingRead() {
        var ring = new SnapshotRing(world, 3);
        ring.publish(1, 0);
        try (WorldSnapshot held = ring.acquireLatest().orElseThrow()) {
            for (int frame = 2; frame < 100; frame++) {
                ring.publish(frame, 0);
            }
            assertThat(held.lost()).isFalse();
            assertThat(held.frame()).isEqualTo(1);
        }
    }

    @Test
    void whenAllSlotsAreHeldTheOldestReaderLosesItsOwn() {
        var ring = new SnapshotRing(world, 3);
        List<WorldSnapshot> held = new ArrayList<>();
        for (int frame = 1; frame <= 3; frame++) {
            ring.publish(frame, 0);
            held.add(ring.acquireLatest().orElseThrow());
        }
        ring.publish(4, 0);
        assertThat(held).extracting(WorldSnapshot::lost).containsExactly(true, false, false);
        ring.publish(5, 0);
        assertThat(held).extracting(WorldSnapshot::lost).containsExactly(true, true, false);
        try (WorldSnapshot latest = ring.acquireLatest().orElseThrow()) {
            assertThat(latest.frame()).isEqualTo(5);
        }
        held.forEach(WorldSnapshot::close);
    }

    @Test
    void aLostSnapshotOfAGrownWorldIsNonsenseButSafeToRead() {
        var ring = new SnapshotRing(world, 2);
        ball("b");
        ring.publish(1, 0);
        WorldSnapshot held = ring.acquireLatest().orElseThrow();
        TableSnapshot body = held.table("body");
        for (int i = 0; i < 1000; i++) {
            ball("b" + i);
        }
        ring.publish(2, 0);
        ring.publish(3, 0);
        assertThat(held.lost()).isTrue();
        assertThat(body.column("mass").getDouble(0, 0)).isNotNaN();
        held.close();
    }

    @Test
    void aClosedSnapshotGivesNoMoreTables() {
        var ring = new SnapshotRing(world, 2);
        ring.publish(1, 0);
        WorldSnapshot snapshot = ring.acquireLatest().orElseThrow();
        snapshot.close();
        snapshot.close();
        assertThatIllegalStateException().isThrownBy(() -> snapshot.table("body"));
        ring.publish(2, 0);
        WorldSnapshot held = ring.acquireLatest().orElseThrow();
        ring.publish(3, 0);
        assertThat(held.lost()).as("closing twice must not free another reader's slot").isFalse();
        held.close();
    }

    @Test
    void aFrameThatCannotBePublishedCostsNoSlotAndIsSeenByNobody() throws Exception {
        var ring = new SnapshotRing(world, 2);
        var slot = new SnapshotSlot(world, new SnapshotSlot.Memory(world));
        ring.publish(1, 0);
        ownedByAnother(
                () -> {
                    assertThatIllegalStateException().isThrownBy(() -> ring.publish(2, 0));
                    assertThatIllegalStateException()
                            .isThrownBy(() -> slot.write(world, 2, 0, null));
                });
        assertThat(slot.acquire()).as("half a frame").isEmpty();
        assertThat(slot.isFree()).isTrue();
        slot.write(world, 3, 0, null);
        try (WorldSnapshot snapshot = slot.acquire().orElseThrow()) {
            assertThat(snapshot.frame()).isEqualTo(3);
            assertThat(snapshot.lost()).isFalse();
        }
        for (int frame = 3; frame < 6; frame++) {
            ring.publish(frame, 0);
            try (WorldSnapshot latest = ring.acquireLatest().orElseThrow()) {
                assertThat(latest.frame()).isEqualTo(frame);
                assertThat(latest.lost()).isFalse();
            }
        }
    }

    /**
     * Runs a task while this thread may not read the world. Therefore the copy fails before it is
     * complete.
     */
    private void ownedByAnother(Runnable meanwhile) throws InterruptedException {
        Thread other = new Thread(world.guard()::claim);
        other.start();
        other.join();
        meanwhile.run();
        world.guard().claim();
    }

    /**
     * Every row contains the number of the frame of its last write. Rows are added and removed, so
     * memory is also replaced.
     */
    @Test
    void readersOnOtherThreadsSeeWholeFramesOrLoseThem() throws Exception {
        var ring = new SnapshotRing(world, 3);
        var done = new AtomicBoolean();
        try (ExecutorService readers = Executors.newFixedThreadPool(2)) {
            List<Future<Integer>> counts = new ArrayList<>();
            for (int i = 0; i < 2; i++) {
                counts.add(readers.submit(() -> readUntil(done, ring)));
            }
            for (int frame = 1; frame <= 3000; frame++) {
                writeFrame(frame);
                ring.publish(frame, frame);
                FrameControl.of(world).endPhysics();
            }
            done.set(true);
            for (Future<Integer> count : counts) {
                assertThat(count.get()).isPositive();
            }
        }
    }

    private void writeFrame(int frame) {
        if (frame % 3 == 0 && frame < 1500) {
            ball("ball" + frame);
        } else if (frame % 5 == 0 && world.items().size() > 2) {
            world.remove(world.table("body").idAt(0));
        }
        Column mass = world.table("body").column("mass");
        for (int row = 0; row < mass.rowCount(); row++) {
            mass.setDouble(row, 0, frame);
        }
    }

    private static int readUntil(AtomicBoolean done, SnapshotRing ring) {
        int whole = 0;
        long last = 0;
        boolean again = true;
        while (again) {
            again = !done.get();
            var latest = ring.acquireLatest();
            if (latest.isEmpty()) {
                again = true;
                continue;
            }
            try (WorldSnapshot snapshot = latest.get()) {
                TableSnapshot body = snapshot.table("body");
                boolean fits = body.rowCount() == snapshot.symbols().size() - 1;
                ColumnSnapshot mass = body.column("mass");
                for (int row = 0; row < body.rowCount(); row++) {
                    fits &= mass.getDouble(row, 0) == snapshot.frame();
                }
                if (!snapshot.lost()) {
                    assertThat(fits).as("frame %d is whole", snapshot.frame()).isTrue();
                    assertThat(snapshot.frame()).isGreaterThanOrEqualTo(last);
                    last = snapshot.frame();
                    whole++;
                }
            }
        }
        return whole;
    }
}
