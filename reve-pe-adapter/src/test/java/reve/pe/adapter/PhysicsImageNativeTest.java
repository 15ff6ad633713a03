// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;

import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsException;
import reve.pe.Status;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Random;

class PhysicsImageNativeTest {
    private static final int HALF = 100;
    private static final long SEED = 20261121;

    /**
     * The world has balls with friction. SCRATCH stores contacts by row, while rows are added and
     * removed.
     */
    @Test
    void aRestoredWorldGoesOnWithTheSameHashes() {
        try (AdapterFixture whole = heap();
                AdapterFixture other = emptyHeap();
                WorldImage image = new WorldImage(whole.world)) {
            Random random = new Random(SEED);
            for (int frame = 1; frame <= HALF; frame++) {
                whole.run(1);
                stir(whole, random, frame);
            }
            image.copyFrom(whole.world, whole.loop.frame());
            PhysicsImage physics = whole.adapter.save();
            Random continued = new Random(SEED + 1);
            List<Long> hashes = new ArrayList<>();
            for (int frame = 1; frame <= HALF; frame++) {
                whole.run(1);
                hashes.add(whole.adapter.stateHash());
                stir(whole, continued, frame);
            }

            other.adapter.restore(image.frame(), physics, () -> other.world.restore(image));
            other.loop.continueAfter(image.frame());
            continued = new Random(SEED + 1);
            for (int frame = 1; frame <= HALF; frame++) {
                other.run(1);
                assertThat(other.adapter.stateHash())
                        .as("frame %d", other.loop.frame())
                        .isEqualTo(hashes.get(frame - 1));
                stir(other, continued, frame);
            }
            assertThat(other.bytes()).isEqualTo(whole.bytes());
            assertThat(other.loop.frame()).isEqualTo(2 * HALF);
        }
    }

    @Test
    void aWorldThatIsPutBackRepeatsItself() {
        try (AdapterFixture world = heap();
                WorldImage image = new WorldImage(world.world)) {
            world.run(HALF);
            image.copyFrom(world.world, world.loop.frame());
            PhysicsImage physics = world.adapter.save();
            world.run(HALF);
            long first = world.adapter.stateHash();
            stir(world, new Random(SEED), 1);
            world.run(3);

            world.adapter.restore(image.frame(), physics, () -> world.world.restore(image));
            world.loop.continueAfter(world.loop.frame() + 1);
            world.run(HALF);
            assertThat(world.adapter.stateHash()).isEqualTo(first);
        }
    }

    @Test
    void lawsComeBackInTheirOrderWithTheirParameters() {
        try (AdapterFixture world = AdapterFixture.springOrbit()) {
            int wind = world.adapter.laws().load(0, "wind", Map.of());
            List<LawLibrary> before = world.adapter.laws().libraries();
            PhysicsImage physics = world.adapter.save();
            world.adapter.laws().unload(0, wind);
            world.adapter.laws().load(0, "writes_nan", Map.of("from_step", 0.0));
            world.run(1); // and it is quarantined

            world.adapter.restore(1, physics, () -> {});

            assertThat(world.adapter.laws().libraries())
                    .usingRecursiveComparison()
                    .isEqualTo(before);
            assertThat(world.adapter.laws().quarantined()).isEmpty();
        }
    }

    @Test
    void aChangeOfLawsCanBeMadeAgainElsewhere() {
        List<LawChange> changes = new ArrayList<>();
        try (AdapterFixture first = AdapterFixture.springOrbit();
                AdapterFixture second = AdapterFixture.springOrbit()) {
            first.adapter.laws().addListener(changes::add);
            int wind = first.adapter.laws().load(0, "wind", Map.of());
            first.adapter.laws().load(0, "writes_nan", Map.of("from_step", 0.0));
            first.run(1);
            first.adapter.laws().unload(1, wind);
            for (LawChange change : changes) {
                second.adapter.laws().apply(0, change);
            }
            assertThat(changes).hasSize(4);
            assertThat(second.adapter.laws().libraries())
                    .usingRecursiveComparison()
                    .isEqualTo(first.adapter.laws().libraries());
            assertThat(second.adapter.laws().quarantined())
                    .isEqualTo(first.adapter.laws().quarantined());
        }
    }

    /**
     * This is also true if the engine sees the world between the removal of the last row and an
     * addition.
     */
    @Test
    void aNewItemHasNoStateOfOneThatHadItsRow() {
        try (AdapterFixture world = emptyHeap().load("counts_years");
                AdapterFixture other = emptyHeap().load("counts_years")) {
            for (AdapterFixture each : List.of(world, other)) {
                each.world.add(ball("first", 0, 0, 0, 0));
                each.world.add(ball("last", 5, 0, 0, 0));
                each.run(3);
                each.world.remove(each.world.find("last").orElseThrow().id());
                if (each == world) {
                    each.adapter.save();
                    each.adapter.stateHash();
                }
                each.world.add(ball("new", 5, 0, 0, 0));
                each.run(1);
            }
            assertThat(other.velocity("new")).startsWith(4);
            assertThat(world.velocity("new")).startsWith(4);
            assertThat(world.adapter.save().engineState())
                    .isEqualTo(other.adapter.save().engineState());
        }
    }

    @Test
    void aDamagedStateIsRefused() {
        try (AdapterFixture world = heap()) {
            PhysicsImage physics = world.adapter.save();
            byte[] flipped = physics.engineState();
            flipped[flipped.length / 2] ^= 1;
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> world.adapter.restore(0, physics, () -> {}))
                    .satisfies(e -> assertThat(e.status()).isEqualTo(Status.INVALID_ARGUMENT));
        }
    }

    /** The second law of the image is refused, after the first one was exchanged. */
    @Test
    void aRewindThatIsRefusedChangesNothing() {
        FailingEngine[] failing = new FailingEngine[1];
        try (AdapterFixture world =
                        new AdapterFixture(
                                WorldPrototype.standard("si-f64"),
                                List.of(ball("one", 0, 1, 0, 1), ball("two", 3, 1, 0, 0)),
                                new OffHeapArena(),
                                false,
                                engine -> failing[0] = new FailingEngine(engine));
                WorldImage image = new WorldImage(world.world)) {
            world.load("newton_motion", "counts_years", "wind");
            world.run(3);
            image.copyFrom(world.world, world.loop.frame());
            PhysicsImage physics = world.adapter.save();
            Laws laws = world.adapter.laws();
            List.copyOf(laws.byId().keySet()).forEach(id -> laws.unload(3, id));
            world.load("drag", "newton_motion");
            laws.load(0, "writes_nan", Map.of("from_step", 12.0));
            world.run(2); // and writes_nan is quarantined
            List<LawChange> told = new ArrayList<>();
            laws.addListener(told::add);

            Map<String, List<Byte>> columns = world.bytes();
            long hash = world.adapter.stateHash();
            Map<Integer, LawLibrary> libraries = laws.byId();
            List<Quarantined> quarantined = laws.quarantined();
            int events = world.events.size();
            PhysicsImage damaged = damaged(physics);
            for (Runnable rewind :
                    List.<Runnable>of(
                            () -> {
                                failing[0].refuseAfter = 1;
                                world.adapter.restore(5, physics, () -> world.world.restore(image));
                            },
                            () ->
                                    world.adapter.restore(
                                            5, damaged, () -> world.world.restore(image)))) {
                assertThatExceptionOfType(PhysicsException.class).isThrownBy(rewind::run);
                assertThat(laws.byId()).isEqualTo(libraries);
                assertThat(laws.quarantined()).isEqualTo(quarantined).hasSize(1);
                assertThat(world.bytes()).isEqualTo(columns);
                assertThat(world.adapter.stateHash()).isEqualTo(hash);
                assertThat(told).isEmpty();
            }
            world.run(1);
            assertThat(world.events).hasSize(events);

            world.adapter.restore(6, physics, () -> world.world.restore(image));
            assertThat(laws.libraries()).usingRecursiveComparison().isEqualTo(physics.libraries());
            assertThat(told).isNotEmpty();
        }
    }

    private static PhysicsImage damaged(PhysicsImage image) {
        byte[] flipped = image.engineState().clone();
        flipped[flipped.length / 2] ^= 1;
        return new PhysicsImage(image.libraries(), image.quarantined(), flipped);
    }

    private static AdapterFixture emptyHeap() {
        return new AdapterFixture(
                WorldPrototype.standard("si-f64"),
                List.of(),
                new OffHeapArena(),
                false,
                engine -> engine);
    }

    /** Returns a world of balls that fall on a rough floor beside each other and rotate. */
    private static AdapterFixture heap() {
        AdapterFixture heap = emptyHeap();
        heap.world.find("world").orElseThrow().physics().set("gravity", 0, -9.81, 0);
        for (int i = 0; i < 12; i++) {
            heap.world.add(ball("ball " + i, 0.9 * (i % 3), 0.6 + 0.95 * (i / 3), 0.1 * i, 0.3));
        }
        heap.load("gravity_field");
        heap.adapter.laws().load(0, "sphere_contact", Map.of("floorHeight", 0.0));
        return heap.load("newton_motion", "angular_motion");
    }

    private static ItemDefinition ball(String name, double x, double y, double z, double vx) {
        return ItemDefinition.named(name)
                .at(x, y, z)
                .physics("mass", 1)
                .physics("radius", 0.5)
                .physics("inertia", 0.1, 0.1, 0.1)
                .physics("velocity", vx, 0, 0)
                .build();
    }

    /**
     * In every tenth frame, adds an item, or removes one, so that another item moves into its row.
     */
    private static void stir(AdapterFixture heap, Random random, int frame) {
        if (frame % 20 == 0) {
            heap.world.add(ball("more " + random.nextLong(), random.nextDouble(), 5, 0.5, 0));
        } else if (frame % 10 == 0) {
            List<Item> balls =
                    heap.world.items().stream().filter(item -> item.kind().equals("body")).toList();
            heap.world.remove(balls.get(random.nextInt(balls.size())).id());
        }
    }
}
