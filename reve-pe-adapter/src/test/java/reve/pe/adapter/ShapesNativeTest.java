// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsException;
import reve.pe.Status;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** The engine receives shapes and scenery while a law uses them, and only then. */
class ShapesNativeTest {
    private static final int SECOND = 60;

    private static AdapterFixture boxOnGround(Shape ofBox) {
        AdapterFixture world =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        List.of(
                                ItemDefinition.named("box")
                                        .at(0, 1.5, 0)
                                        .shape(ofBox)
                                        .physics("mass", 2)
                                        .build(),
                                ItemDefinition.named("ground")
                                        .at(0, -0.5, 0)
                                        .shape(Shape.box(10, 1, 10))
                                        .build(),
                                ItemDefinition.named("handle")
                                        .parent("box")
                                        .at(0, 0.2, 0)
                                        .shape(Shape.sphere(0.5))
                                        .build()),
                        new OffHeapArena(),
                        true,
                        engine -> engine);
        world.world.find("world").orElseThrow().physics().set("gravity", 0, -9.81, 0);
        return world.load("gravity_field");
    }

    private static double height(AdapterFixture world) {
        return world.world.find("box").orElseThrow().physical().location()[1];
    }

    @Test
    void aBoxRestsOnSceneryAndItsHandleDoesNotPushIt() {
        try (AdapterFixture world = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact")) {
            world.run(3 * SECOND);
            assertThat(height(world)).isCloseTo(0.5, within(2e-3));
            assertThat(world.events("fault")).isEmpty();
        }
    }

    @Test
    void shapesAreInTheStateHashOnlyWhileALawUsesThem() {
        try (AdapterFixture small = boxOnGround(Shape.box(1, 1, 1));
                AdapterFixture large = boxOnGround(Shape.box(2, 1, 1))) {
            assertThat(small.adapter.stateHash()).isEqualTo(large.adapter.stateHash());
            long without = small.adapter.stateHash();
            List<Integer> libraries = new ArrayList<>();
            for (AdapterFixture world : List.of(small, large)) {
                libraries.add(world.adapter.laws().load(0, "rigid_contact", Map.of()));
            }
            assertThat(small.adapter.stateHash()).isNotEqualTo(large.adapter.stateHash());
            assertThat(small.adapter.stateHash()).isNotEqualTo(without);
            small.adapter.laws().unload(0, libraries.getFirst());
            assertThat(small.adapter.stateHash()).isEqualTo(without);
        }
    }

    @Test
    void rowsThatComeAndGoKeepTheSceneryInPlace() {
        try (AdapterFixture world = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact")) {
            world.run(2 * SECOND);
            for (int i = 0; i < 5; i++) {
                world.world.add(
                        ItemDefinition.named("ball " + i)
                                .at(1.5 + 0.7 * i, 0.5, 0)
                                .shape(Shape.sphere(0.3))
                                .physics("mass", 1)
                                .build());
                world.world.add(
                        ItemDefinition.named("step " + i)
                                .at(i, 0.1, 3)
                                .shape(Shape.box(1, 0.2, 1))
                                .build());
                world.run(10);
            }
            world.world.remove(world.world.find("ball 1").orElseThrow().id());
            world.run(2 * SECOND);
            assertThat(height(world)).isCloseTo(0.5, within(2e-3));
            assertThat(world.world.find("ball 4").orElseThrow().physical().location()[1])
                    .isCloseTo(0.3, within(2e-3));
        }
    }

    @Test
    void aDetachedItemBecomesScenery() {
        try (AdapterFixture world = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact")) {
            world.run(2 * SECOND);
            var handle = world.world.find("handle").orElseThrow();
            world.world.detach(handle.id());
            world.run(2 * SECOND);
            assertThat(height(world)).as("the handle pushes it").isNotCloseTo(0.5, within(0.05));
        }
    }

    @Test
    void aRestoredWorldContinuesToTheBit() {
        try (AdapterFixture whole = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact");
                AdapterFixture other = boxOnGround(Shape.box(1, 1, 1));
                WorldImage image = new WorldImage(whole.world)) {
            whole.run(45);
            image.copyFrom(whole.world, whole.loop.frame());
            PhysicsImage physics = whole.adapter.save();
            whole.run(SECOND);
            other.adapter.restore(image.frame(), physics, () -> other.world.restore(image));
            other.loop.continueAfter(image.frame());
            other.run(SECOND);
            assertThat(other.adapter.stateHash()).isEqualTo(whole.adapter.stateHash());
        }
    }

    /** An octahedron, with faces that are counter-clockwise as seen from outside. */
    private static Mesh octahedron(float half) {
        float h = half;
        return new Mesh(
                new float[] {h, 0, 0, -h, 0, 0, 0, h, 0, 0, -h, 0, 0, 0, h, 0, 0, -h},
                new int[] {2, 4, 0, 2, 0, 5, 2, 5, 1, 2, 1, 4, 3, 0, 4, 3, 5, 0, 3, 1, 5, 3, 4, 1});
    }

    /** Two triangles that face upwards. */
    private static Mesh floor() {
        return new Mesh(
                new float[] {-5, 0, -5, 5, 0, -5, -5, 0, 5, 5, 0, 5}, new int[] {0, 2, 1, 1, 2, 3});
    }

    private static AdapterFixture stonesOnFloor() {
        List<ItemDefinition> items = new ArrayList<>();
        for (int i = 0; i < 3; i++) {
            items.add(
                    ItemDefinition.named("stone " + i)
                            .at(2 * i - 2, 1, 0)
                            .shape(octahedron(0.5f))
                            .physics("mass", 2)
                            .physics("angularVelocity", 1, 0.3, 0.2)
                            .build());
        }
        items.add(ItemDefinition.named("floor").shape(floor()).build());
        AdapterFixture world =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        items,
                        new OffHeapArena(),
                        true,
                        engine -> engine);
        world.world.find("world").orElseThrow().physics().set("gravity", 0, -9.81, 0);
        return world.load("gravity_field").load("rigid_contact");
    }

    private static double heightOf(AdapterFixture world, String item) {
        return world.world.find(item).orElseThrow().physical().location()[1];
    }

    @Test
    void aMeshThatMovesTouchesWithItsHullAndAMeshAsSceneryWithItsTriangles() {
        try (AdapterFixture world = stonesOnFloor()) {
            world.run(5 * SECOND);
            assertThat(world.events("fault")).isEmpty();
            for (int i = 0; i < 3; i++) { // on a face, at the distance of the face from the centre
                assertThat(heightOf(world, "stone " + i))
                        .isCloseTo(0.5 / Math.sqrt(3), within(2e-3));
            }
        }
    }

    @Test
    void meshesMayComeAndGo() {
        try (AdapterFixture world = stonesOnFloor()) {
            world.run(3 * SECOND);
            world.world.remove(world.world.find("stone 0").orElseThrow().id());
            world.world.add(
                    ItemDefinition.named("pebble")
                            .at(-1, 1.5, 1)
                            .shape(octahedron(0.2f))
                            .physics("mass", 1)
                            .physics("angularVelocity", 1, 0.3, 0.2)
                            .build());
            world.run(5 * SECOND);
            assertThat(world.events("fault")).isEmpty();
            assertThat(heightOf(world, "pebble")).isCloseTo(0.2 / Math.sqrt(3), within(2e-3));
            assertThat(heightOf(world, "stone 2")).isCloseTo(0.5 / Math.sqrt(3), within(2e-3));
        }
    }

    @Test
    void aMeshThatHasLeftLeavesNoTraceInTheStateHash() {
        try (AdapterFixture without = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact");
                AdapterFixture with = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact")) {
            without.run(10);
            with.run(5);
            with.world.add(ItemDefinition.named("far").at(0, 0, 900).shape(floor()).build());
            with.run(2);
            with.world.remove(with.world.find("far").orElseThrow().id());
            with.run(3);
            assertThat(with.adapter.stateHash()).isEqualTo(without.adapter.stateHash());
        }
    }

    @Test
    void aRestoredWorldWithMeshesContinuesToTheBit() {
        try (AdapterFixture whole = stonesOnFloor();
                AdapterFixture other = stonesOnFloor();
                WorldImage image = new WorldImage(whole.world)) {
            whole.run(35);
            image.copyFrom(whole.world, whole.loop.frame());
            PhysicsImage physics = whole.adapter.save();
            whole.run(SECOND);
            other.adapter.restore(image.frame(), physics, () -> other.world.restore(image));
            other.loop.continueAfter(image.frame());
            other.run(SECOND);
            assertThat(other.adapter.stateHash()).isEqualTo(whole.adapter.stateHash());
        }
    }

    @Test
    void anItemMayComeInTheFrameInWhichALawUsesShapes() {
        try (AdapterFixture world = boxOnGround(Shape.box(1, 1, 1))) {
            world.run(1);
            world.load("rigid_contact");
            world.world.add(
                    ItemDefinition.named("ball")
                            .at(3, 0.3, 0)
                            .shape(Shape.sphere(0.3))
                            .physics("mass", 1)
                            .build());
            world.run(3 * SECOND);
            assertThat(world.events("fault")).isEmpty();
            assertThat(height(world)).isCloseTo(0.5, within(2e-3));
        }
    }

    @Test
    void aHingeHoldsADoorAndTellsItsAngle() {
        try (AdapterFixture world =
                new AdapterFixture(
                                WorldPrototype.standard("si-f64").withJoints(),
                                List.of(
                                        ItemDefinition.named("frame").physics("mass", 0).build(),
                                        ItemDefinition.named("door")
                                                .at(0.5, 0, 0)
                                                .shape(Shape.box(1, 2, 0.1))
                                                .physics("mass", 20)
                                                .physics("appliedForce", 0, 0, -10)
                                                .build(),
                                        ItemDefinition.named("hinge")
                                                .kind("joint")
                                                .reference("joined", "frame", "door")
                                                .physics("jointType", 3)
                                                .physics("axis", 0, 1, 0)
                                                .physics("angleLimits", -0.1, 0.5)
                                                .build()),
                                new OffHeapArena(),
                                true,
                                engine -> engine)
                        .load("rigid_contact")) {
            world.run(4 * SECOND);
            assertThat(world.events("fault")).isEmpty();
            double[] place = world.world.find("door").orElseThrow().physical().location();
            assertThat(Math.hypot(place[0], place[2])).isCloseTo(0.5, within(1e-3));
            assertThat(world.world.find("hinge").orElseThrow().physics().scalar("jointAngle"))
                    .isCloseTo(0.5, within(5e-3));
        }
    }

    @Test
    void aSecondIntegratorIsRefusedByName() {
        try (AdapterFixture world = boxOnGround(Shape.box(1, 1, 1)).load("rigid_contact")) {
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> world.load("newton_motion"))
                    .satisfies(
                            refused ->
                                    assertThat(refused.status()).isEqualTo(Status.ACCESS_CONFLICT))
                    .withMessageContaining("rigid_contact");
        }
    }
}
