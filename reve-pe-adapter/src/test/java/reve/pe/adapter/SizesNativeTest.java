// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Status;

import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Map;

/** Laws change the sizes of bodies, and shapes and contacts follow. */
class SizesNativeTest {
    private static final int SECOND = 60;

    /** Diameters grow by 0.1 m/s. */
    private static final String GROW =
            """
            law grow
              parameter v = 0.1 m/s, from -1e3 m/s to 1e3 m/s
              each body:
                size += v dt (1, 1, 1)
            """;

    /** Balls grow, which are as high as wide. */
    private static final String GROW_BALLS =
            GROW.replace("    size +=", "    if size.x = size.y: size +=");

    private static AdapterFixture world(ItemDefinition... items) {
        return new AdapterFixture(
                WorldPrototype.standard("si-f64"),
                List.of(items),
                new OffHeapArena(),
                true,
                engine -> engine);
    }

    private static ItemDefinition body(String name, Shape shape, double height) {
        return ItemDefinition.named(name).at(0, height, 0).shape(shape).physics("mass", 1).build();
    }

    private static int load(AdapterFixture world, String text, Map<String, Double> parameters) {
        String file = text.split("\\s+", 3)[1] + ".law";
        try (PreparedLibrary library =
                world.engine.prepareText(file, text.getBytes(StandardCharsets.UTF_8))) {
            return world.adapter.laws().load(world.loop.frame(), library, parameters);
        }
    }

    private static Shape shape(AdapterFixture world, String item) {
        return world.world.find(item).orElseThrow().physical().shape();
    }

    private static double height(AdapterFixture world, String item) {
        return world.world.find(item).orElseThrow().physical().location()[1];
    }

    @Test
    void aShapeFollowsTheSizeThatALawWrites() {
        try (AdapterFixture world =
                world(
                        body("ball", Shape.sphere(0.5), 0),
                        body("box", Shape.box(1, 2, 3), 5),
                        body("point", Shape.none(), 9))) {
            load(world, GROW, Map.of());
            world.run(10 * SECOND);
            assertThat(world.events("fault")).isEmpty();
            for (int axis = 0; axis < 3; axis++) {
                assertThat(shape(world, "ball").size(axis)).isCloseTo(2, within(1e-12));
                assertThat(shape(world, "box").size(axis)).isCloseTo(2 + axis, within(1e-12));
            }
            assertThat(world.world.find("point").orElseThrow().physical().size())
                    .containsExactly(0, 0, 0);
            assertThat(world.world.find("ball").orElseThrow().physics().scalar("mass"))
                    .isEqualTo(1);
        }
    }

    /**
     * The bottom of the lid is as high as the ball, whose diameter grows by 0.1 m/s. The ball
     * overlaps the ground and the lid while it pushes them apart.
     */
    @Test
    void aGrowingBallLiftsTheBoxThatLiesOnIt() {
        try (AdapterFixture world =
                world(
                        ItemDefinition.named("ground")
                                .at(0, -0.5, 0)
                                .shape(Shape.box(10, 1, 10))
                                .build(),
                        body("ball", Shape.sphere(0.5), 0.5),
                        body("lid", Shape.box(1, 0.2, 1), 1.1))) {
            world.world.find("world").orElseThrow().physics().set("gravity", 0, -9.81, 0);
            world.load("gravity_field", "rigid_contact");
            load(world, GROW_BALLS, Map.of());
            world.run(5 * SECOND);
            assertThat(world.events("fault")).isEmpty();
            assertThat(shape(world, "ball").size(0)).isCloseTo(1.5, within(1e-12));
            assertThat(shape(world, "lid")).isEqualTo(Shape.box(1, 0.2, 1));
            assertThat(height(world, "ball")).isCloseTo(0.75, within(2e-3));
            assertThat(height(world, "lid")).isCloseTo(1.6, within(0.01));
        }
    }

    @Test
    void sizesAreInTheStateHashOnlyWhileALawUsesThem() {
        try (AdapterFixture small = world(body("ball", Shape.sphere(0.5), 0));
                AdapterFixture large = world(body("ball", Shape.sphere(0.7), 0))) {
            long without = small.adapter.stateHash();
            assertThat(large.adapter.stateHash()).isEqualTo(without);
            int library = load(small, GROW, Map.of());
            load(large, GROW, Map.of());
            assertThat(small.adapter.stateHash())
                    .isNotEqualTo(without)
                    .isNotEqualTo(large.adapter.stateHash());
            small.adapter.laws().unload(0, library);
            assertThat(small.adapter.stateHash()).isEqualTo(without);
        }
    }

    @Test
    void aRestoredWorldContinuesToTheBit() {
        ItemDefinition[] items = {
            body("ball", Shape.sphere(0.5), 0), body("box", Shape.box(1, 2, 3), 5)
        };
        try (AdapterFixture whole = world(items);
                AdapterFixture other = world(items);
                WorldImage image = new WorldImage(whole.world)) {
            load(whole, GROW, Map.of());
            whole.run(45);
            image.copyFrom(whole.world, whole.loop.frame());
            PhysicsImage physics = whole.adapter.save();
            whole.run(SECOND);
            other.adapter.restore(image.frame(), physics, () -> other.world.restore(image));
            other.loop.continueAfter(image.frame());
            other.run(SECOND);
            assertThat(other.adapter.stateHash()).isEqualTo(whole.adapter.stateHash());
            assertThat(shape(other, "ball")).isEqualTo(shape(whole, "ball"));
        }
    }

    /** In each frame, the sizes lose 0.1 m. */
    @Test
    void aNegativeSizeIsAFaultOfTheLaw() {
        try (AdapterFixture world =
                world(body("ball", Shape.sphere(1), 0), body("box", Shape.box(1.05, 2, 3), 5))) {
            load(world, GROW, Map.of("v", -6.0));
            world.run(SECOND);
            assertThat(world.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault -> {
                                assertThat(fault.frame()).isEqualTo(11);
                                assertThat(fault.fields())
                                        .containsEntry("law", "grow")
                                        .containsEntry("property", "size")
                                        .containsEntry("item", "box");
                                assertThat(fault.fields().get("message"))
                                        .asString()
                                        .contains("expected 0 or more");
                            });
            // The state is that of the last frame before the fault.
            assertThat(shape(world, "box").size(0)).isCloseTo(0.05, within(1e-12));
            assertThat(world.world.find("box").orElseThrow().physical().size()[0])
                    .isEqualTo(shape(world, "box").size(0));
            assertThat(world.adapter.laws().quarantined()).hasSize(1);
        }
    }

    @Test
    void aSizeOfZeroIsReportedOnceAndTheItemKeepsItsShape() {
        try (AdapterFixture world = world(body("ball", Shape.sphere(0.5), 0))) {
            load(
                    world,
                    """
                    law vanish
                      each body: size = (0, 0, 0)
                    """,
                    Map.of());
            world.run(10);
            assertThat(shape(world, "ball")).isEqualTo(Shape.sphere(0.5));
            assertThat(world.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("law", "vanish")
                                            .containsEntry("property", "size")
                                            .containsEntry("item", "ball"));
            assertThat(world.adapter.laws().loaded()).hasSize(1);
        }
    }

    @Test
    void theEngineInAProcessOfItsOwnGivesTheSameBits() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture inProcess = HostedFixture.inProcess()) {
            for (AdapterFixture world : List.of(hosted.world, inProcess)) {
                for (int i = 0; i < 5; i++) {
                    world.world.add(body("ball " + i, Shape.sphere(0.5 + i), 5));
                    world.world.add(body("can " + i, Shape.capsule(0.5 + i, 4 + 2 * i), 5));
                }
                load(world, GROW, Map.of());
                world.run(SECOND);
                assertThat(world.events("fault")).isEmpty();
                assertThat(shape(world, "can 3").size(1)).isCloseTo(10.1, within(1e-12));
            }
            assertThat(hosted.world.adapter.stateHash()).isEqualTo(inProcess.adapter.stateHash());
            assertThat(hosted.world.bytes()).isEqualTo(inProcess.bytes());
        }
    }

    @Test
    void twoLawsOfAPhaseThatWriteSizesAreRefused() {
        try (AdapterFixture world = world(body("ball", Shape.sphere(0.5), 0))) {
            load(world, GROW, Map.of());
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> load(world, GROW.replace("law grow", "law more"), Map.of()))
                    .satisfies(
                            refused ->
                                    assertThat(refused.status()).isEqualTo(Status.ACCESS_CONFLICT))
                    .withMessageContaining("size");
        }
    }
}
