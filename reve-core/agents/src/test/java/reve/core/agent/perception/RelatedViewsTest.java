// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.derive.BoundingBoxes;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.OffHeapArena;
import reve.core.world.Relations;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;

/**
 * The clock advances by 4 ms with each reading. Therefore a slice has time for only a few items.
 */
class RelatedViewsTest {
    private static final int ITEMS = 200;

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", WorldPrototype.standard("si-f64"), arena);
    private final SnapshotRing ring = new SnapshotRing(world, 2);
    private final Observatory observatory = new Observatory();
    private final List<Item> items = new ArrayList<>();
    private final Random random = new Random(Seed.of("related views"));
    private final Perceiver ada = new Perceiver(false);
    private final Perceiver bob = new Perceiver(false);
    private final Perceiver robot = new Perceiver(true);
    private final Set<Perceiver> members = new HashSet<>(Set.of(ada, bob, robot));

    private long now;
    private final RelatedViews<Perceiver> views = new RelatedViews<>(() -> now += 4_000_000);

    /** Relations by frame, item and relation, as the world itself computes them. */
    private final Map<Long, Map<String, Map<String, List<String>>>> expected = new HashMap<>();

    private static final class Perceiver implements RelatedViews.Client {
        private final boolean lockStep;
        private long asksFrom;

        Perceiver(boolean lockStep) {
            this.lockStep = lockStep;
        }

        @Override
        public boolean isInLockStep() {
            return lockStep;
        }

        @Override
        public boolean wantsRelations(long frame) {
            return frame >= asksFrom;
        }

        @Override
        public Optional<Set<ItemId>> sensedIn(long frame) {
            return Optional.empty();
        }

        @Override
        public View relate(View view, Optional<Set<ItemId>> fresh) {
            return view;
        }
    }

    @BeforeEach
    void fill() {
        for (int i = 0; i < ITEMS; i++) {
            items.add(
                    world.add(
                            ItemDefinition.named("i" + i)
                                    .shape(Shape.box(1, 0.5 * random.nextInt(1, 4), 1))
                                    .build()));
        }
        world.add(ItemDefinition.named("point").build());
    }

    @AfterEach
    void free() {
        arena.close();
    }

    private void next(long frame) {
        for (Item item : items) {
            item.physical()
                    .setLocation(
                            0.5 * random.nextInt(10),
                            0.25 * random.nextInt(10),
                            0.5 * random.nextInt(10));
        }
        new BoundingBoxes().update(world);
        ring.publish(frame, 0.1 * frame);
        try (var snapshot = ring.acquireLatest().orElseThrow()) {
            assertThat(observatory.read(snapshot)).isTrue();
            var all = new HashMap<String, Map<String, List<String>>>();
            for (Item item : items) {
                var relations = new HashMap<String, List<String>>();
                for (String relation : Relations.NAMES) {
                    relations.put(
                            relation, snapshot.relations().of(item.id(), relation).orElseThrow());
                }
                all.put(item.name(), relations);
            }
            all.put("point", Map.of());
            expected.put(frame, all);
        }
    }

    private Optional<View> ask(Perceiver perceiver) {
        return views.of(perceiver, () -> Optional.of(observatory.everything()), observatory);
    }

    private View askInSlices(Perceiver perceiver) {
        for (int slices = 1; ; slices++) {
            views.begin(members::contains);
            Optional<View> view = ask(perceiver);
            if (view.isPresent()) {
                assertThat(slices).as("slices").isGreaterThan(1);
                return view.get();
            }
            assertThat(slices).as("slices").isLessThan(ITEMS);
        }
    }

    private void assertRelationsOf(long frame, View view) {
        assertThat(view.frame()).isEqualTo(frame);
        var told = new HashMap<String, Map<String, List<String>>>();
        view.items().forEach(seen -> told.put(seen.name(), seen.relations()));
        assertThat(told).isEqualTo(expected.get(frame));
    }

    @Test
    void relationsFoundInSlicesAreThoseOfTheFrameThatWasAskedIn() {
        next(1);
        views.begin(members::contains);
        assertThat(ask(ada)).isEmpty();
        next(2);
        assertThat(ask(bob)).as("while ada waits for frame 1").isEmpty();
        assertRelationsOf(1, askInSlices(ada));
        next(3);
        assertRelationsOf(3, askInSlices(bob));
        assertRelationsOf(3, ask(ada).orElseThrow());
    }

    @Test
    void whoIsInLockStepGetsThemAtOnceAndTheOthersBeginAnew() {
        next(1);
        views.begin(members::contains);
        assertThat(ask(ada)).isEmpty();
        next(2);
        assertRelationsOf(2, ask(robot).orElseThrow());
        assertRelationsOf(2, ask(ada).orElseThrow());
    }

    @Test
    void whoLeavesOrAsksForSomethingElseKeepsNobodyWaiting() {
        next(1);
        views.begin(members::contains);
        assertThat(ask(ada)).isEmpty();
        next(2);
        members.remove(ada);
        assertRelationsOf(2, askInSlices(bob));

        members.add(ada);
        next(3);
        views.begin(members::contains);
        assertThat(ask(ada)).isEmpty();
        next(4);
        ada.asksFrom = 4;
        assertRelationsOf(4, askInSlices(bob));
        assertRelationsOf(4, ask(ada).orElseThrow());
    }

    @Test
    void whatHasNotMovedNeedsNoTime() {
        next(1);
        View before = askInSlices(ada);
        ring.publish(2, 0.2);
        try (var snapshot = ring.acquireLatest().orElseThrow()) {
            assertThat(observatory.read(snapshot)).isTrue();
        }
        View view = ask(ada).orElseThrow();
        assertThat(view.frame()).isEqualTo(2);
        assertThat(view.items()).isEqualTo(before.items());
    }
}
