// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.derive.BoundingBoxes;
import reve.core.world.Colour;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemDefinition;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.Texture;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.nio.ByteBuffer;
import java.nio.file.Path;
import java.util.Optional;

class SceneBuilderIT {

    private static final Environment FLAT =
            new Environment(
                    Colour.parse("#000000"), Colour.parse("#000000"), new Point(0, 0, 1), 0, 1);
    private static final ImageFormat SMALL = new ImageFormat(200, 200, 0, false);

    /** A camera that looks along -z. It shows 20 x 20 m with 10 pixels per metre. */
    private static final Camera FRONT =
            Camera.orthographic(new Point(0, 0, 50), new Point(0, 0, 0), new Point(0, 1, 0), 20);

    private static World world(String prototype) {
        return new World("test", WorldPrototype.standard(prototype), new OffHeapArena());
    }

    private static ItemDefinition.Builder ball(String name, String colour) {
        return ItemDefinition.named(name).shape(Shape.sphere(1)).colour(colour);
    }

    private static WorldSnapshot snapshot(World world) {
        new BoundingBoxes().update(world);
        var ring = new SnapshotRing(world, 2);
        ring.publish(1, 0);
        return ring.acquireLatest().orElseThrow();
    }

    private static Scene build(World world, Optional<Camera> camera) {
        try (WorldSnapshot snapshot = snapshot(world)) {
            return new SceneBuilder(SMALL, FLAT, camera).build(snapshot);
        }
    }

    private static Picture draw(World world, Optional<Camera> camera) {
        try (var renderer =
                new Renderer(
                        Path.of(System.getProperty("reve.native.path", "build/native")),
                        Renderer.DEFAULT_DEADLINE)) {
            return Picture.decode(renderer.render(build(world, camera)));
        }
    }

    private static boolean isMostly(int rgb, int shift) {
        int wanted = rgb >> shift & 0xff;
        return wanted > 2 * ((rgb >> (shift + 8) % 24) & 0xff)
                && wanted > 2 * ((rgb >> (shift + 16) % 24) & 0xff);
    }

    @Test
    void everyPixelKnowsItsItemAndItsDepth() {
        World world = world("si-f64");
        long ball =
                world.add(ball("ball", "#ff0000").at(-5, 5, 0).physics("mass", 1).build())
                        .id()
                        .value();
        long box =
                world.add(
                                ItemDefinition.named("box")
                                        .shape(Shape.box(4, 2, 2))
                                        .at(5, 5, 0)
                                        .physics("mass", 1)
                                        .build())
                        .id()
                        .value();
        long spring =
                world.add(
                                ItemDefinition.named("spring")
                                        .kind("spring")
                                        .physics("springConstant", 1)
                                        .physics("length", 1)
                                        .reference("end1", "ball")
                                        .reference("end2", "box")
                                        .build())
                        .id()
                        .value();
        world.add(
                ItemDefinition.named("glass")
                        .shape(Shape.box(20, 20, 1))
                        .colour("#00000000")
                        .at(0, 0, 9)
                        .build());
        var front =
                Camera.perspective(
                        new Point(0, 0, 50),
                        new Point(0, 0, 0),
                        new Point(0, 1, 0),
                        2 * Math.atan(0.2));
        try (var renderer =
                new Renderer(
                        Path.of(System.getProperty("reve.native.path", "build/native")),
                        Renderer.DEFAULT_DEADLINE)) {
            PixelLayers seen =
                    renderer.pixels(
                            build(world, Optional.of(front)),
                            PixelLayers.COLOUR | PixelLayers.DEPTH | PixelLayers.ITEM);
            ByteBuffer item = seen.item().orElseThrow();
            ByteBuffer depth = seen.depth().orElseThrow();
            int row = 50 * 200; // 10 pixels per metre at the target: y = 5
            assertThat(item.getInt(4 * (row + 50))).isEqualTo((int) ball);
            assertThat(item.getInt(4 * (row + 100))).isEqualTo((int) spring);
            assertThat(item.getInt(4 * (row + 150))).isEqualTo((int) box);
            assertThat(item.getInt(4 * (150 * 200 + 100))).isZero();
            assertThat(depth.getFloat(4 * (row + 150))).isCloseTo(49, within(1e-3f));
            assertThat(depth.getFloat(4 * (row + 100))).isCloseTo(50, within(0.05f));
            assertThat(seen.colour().orElseThrow().get(3 * (row + 50))).isNotZero();
            assertThat(renderer.pixels(build(world, Optional.of(front)), PixelLayers.ITEM))
                    .isEqualTo(
                            new PixelLayers(
                                    200, 200, Optional.empty(), Optional.empty(), seen.item()));
        }
    }

    @Test
    void itemsFarBeyondTheWorldAreLeftOut() {
        World world = world("si-f64");
        world.add(ball("red", "#ff0000").at(-5, 5, 0).physics("mass", 1).build());
        world.add(ball("lost", "#ffffff").at(1e16, 0, 0).physics("mass", 1).build());
        world.add(
                ItemDefinition.named("spring")
                        .kind("spring")
                        .physics("springConstant", 1)
                        .physics("length", 1)
                        .reference("end1", "red")
                        .reference("end2", "lost")
                        .build());
        Picture seen = draw(world, Optional.of(FRONT));
        assertThat(isMostly(seen.at(50, 50), 16)).isTrue();
        assertThat(isMostly(draw(world, Optional.empty()).at(100, 100), 16)).isTrue();
    }

    @ParameterizedTest
    @ValueSource(strings = {"si-f32", "si-f64"})
    void bodiesAndSpringsShowWhereTheyAre(String prototype) {
        World world = world(prototype);
        world.add(ball("red", "#ff0000").at(-5, 5, 0).physics("mass", 1).build());
        world.add(
                ItemDefinition.named("blue")
                        .shape(Shape.box(4, 2, 2))
                        .colour("#0000ff")
                        .at(5, 5, 0)
                        .physics("mass", 1)
                        .build());
        world.add(
                ItemDefinition.named("green")
                        .colour("#00ff00")
                        .at(0, -5, 0)
                        .shape(
                                Shape.mesh(
                                        new float[] {-2, -1, 0, 2, -1, 0, 0, 2, 0},
                                        new int[] {0, 1, 2}))
                        .build());
        world.add(
                ItemDefinition.named("spring")
                        .kind("spring")
                        .physics("springConstant", 1)
                        .physics("length", 1)
                        .reference("end1", "red")
                        .reference("end2", "blue")
                        .build());
        Picture picture = draw(world, Optional.of(FRONT));
        assertThat(isMostly(picture.at(50, 50), 16)).isTrue();
        assertThat(isMostly(picture.at(150, 50), 0)).isTrue();
        assertThat(isMostly(picture.at(100, 150), 8)).isTrue();
        assertThat(picture.at(100, 50)).as("spring").isEqualTo(0x6e7682);
        assertThat(picture.at(100, 40)).as("above the spring").isZero();
        assertThat(picture.at(25, 50)).as("beyond the spring").isZero();
        assertThat(picture.count(rgb -> isMostly(rgb, 0))).isEqualTo(40 * 20);
    }

    private static ItemDefinition.Builder corner(String name, String colour) {
        return ItemDefinition.named(name).colour(colour).physics("mass", 1);
    }

    private static ItemDefinition surface(String name, String... corners) {
        return ItemDefinition.named(name)
                .kind("surface")
                .physics("hardness", 1)
                .reference("vertices", corners)
                .build();
    }

    @Test
    void surfacesAreTrianglesInTheColoursOfTheirCorners() {
        World world = world("si-f64");
        world.add(corner("a", "#ff0000").at(-5, -5, 0).build());
        world.add(corner("b", "#00ff00").at(5, -5, 0).build());
        world.add(corner("c", "#0000ff").at(0, 5, 0).build());
        world.add(surface("face", "a", "b", "c"));
        Picture picture = draw(world, Optional.of(FRONT));
        assertThat(isMostly(picture.at(55, 147), 16)).isTrue();
        assertThat(isMostly(picture.at(144, 147), 8)).isTrue();
        assertThat(isMostly(picture.at(100, 57), 0)).isTrue();
        assertThat(picture.at(100, 155)).as("below").isZero();
        try (WorldSnapshot snapshot = snapshot(world)) {
            assertThat(SceneBuilder.bounds(snapshot))
                    .contains(new Bounds(new Point(-5, -5, 0), new Point(5, 5, 0)));
        }
    }

    @Test
    void whatHasAColourWithoutAlphaIsHidden() {
        World world = world("si-f64");
        world.add(corner("a", "#ff000000").at(-5, -5, 0).build());
        world.add(corner("b", "#ff000000").at(5, -5, 0).build());
        world.add(corner("c", "#ff000000").at(0, 5, 0).build());
        world.add(ball("d", "#ff000000").at(0, 0, 2).build());
        world.add(surface("face", "a", "b", "c"));
        assertThat(draw(world, Optional.of(FRONT)).count(rgb -> isMostly(rgb, 16))).isZero();
        try (WorldSnapshot snapshot = snapshot(world)) {
            assertThat(SceneBuilder.bounds(snapshot)).isEmpty();
        }
    }

    private static Material painted(int... rgba) {
        var pixels = ByteBuffer.allocate(4 * rgba.length);
        for (int pixel : rgba) {
            pixels.putInt(pixel);
        }
        return new Material(
                Colour.WHITE,
                1,
                0,
                Optional.of(new Texture(rgba.length, 1, pixels.array(), Optional.empty())));
    }

    @Test
    void bodiesWearTheirMaterialAndMeshesThatOfTheirParts() {
        World world = world("si-f64");
        world.add(
                ItemDefinition.named("box")
                        .shape(Shape.box(4, 4, 4))
                        .at(-5, 0, 0)
                        .material(painted(0xff0000ff, 0x0000ffff))
                        .build());
        Mesh square =
                Mesh.builder(
                                new float[] {-2, -2, 0, 2, -2, 0, 2, 2, 0, -2, 2, 0},
                                new int[] {0, 1, 2, 0, 2, 3})
                        .part(1, painted(0x00ff00ff))
                        .part(1, new Material(Colour.parse("#0000ff"), 1, 0, Optional.empty()))
                        .textureCoordinates(new float[8])
                        .build();
        world.add(ItemDefinition.named("own").shape(square).at(5, 5, 0).build());
        world.add(
                ItemDefinition.named("given")
                        .shape(square)
                        .at(5, -5, 0)
                        .colour("#ff0000")
                        .material(Material.DEFAULT)
                        .build());
        Picture picture = draw(world, Optional.of(FRONT));
        assertThat(isMostly(picture.at(40, 100), 16)).as("left of the texture").isTrue();
        assertThat(isMostly(picture.at(60, 100), 0)).as("right of the texture").isTrue();
        assertThat(isMostly(picture.at(160, 60), 8)).as("first part").isTrue();
        assertThat(isMostly(picture.at(140, 40), 0)).as("second part").isTrue();
        assertThat(isMostly(picture.at(160, 160), 16)).as("the item's material").isTrue();
        assertThat(isMostly(picture.at(140, 140), 16)).as("the item's material").isTrue();
    }

    @Test
    void aTurnedBodyIsShownTurned() {
        World world = world("si-f64");
        double half = Math.sqrt(0.5);
        world.add(
                ItemDefinition.named("bar")
                        .shape(Shape.box(8, 1, 1))
                        .colour("#ff0000")
                        .orientation(0, 0, half, half)
                        .build());
        Picture picture = draw(world, Optional.of(FRONT));
        assertThat(isMostly(picture.at(100, 65), 16)).isTrue();
        assertThat(isMostly(picture.at(65, 100), 16)).isFalse();
    }

    /** The half axes are 6, 2 and 1 m. The body is turned by 90° about the direction of view. */
    @Test
    void anEllipsoidIsAsWideAndHighAsItsAxes() {
        World world = world("si-f64");
        double half = Math.sqrt(0.5);
        world.add(
                ItemDefinition.named("egg")
                        .shape(Shape.ellipsoid(12, 4, 2))
                        .colour("#ff0000")
                        .orientation(0, 0, half, half)
                        .build());
        Picture picture = draw(world, Optional.of(FRONT));
        for (int[] inside : new int[][] {{100, 42}, {100, 158}, {82, 100}, {118, 100}, {113, 60}}) {
            assertThat(picture.at(inside[0], inside[1]) & 0xff0000)
                    .as("%d, %d", inside[0], inside[1])
                    .isNotZero();
        }
        for (int[] outside :
                new int[][] {{100, 38}, {100, 162}, {78, 100}, {122, 100}, {118, 55}}) {
            assertThat(picture.at(outside[0], outside[1]) & 0xff0000)
                    .as("%d, %d", outside[0], outside[1])
                    .isZero();
        }
    }

    @Test
    void withoutACameraAllBodiesAreInThePicture() {
        World world = world("si-f64");
        world.add(ball("red", "#ff0000").at(-300, 40, 0).build());
        world.add(ball("blue", "#0000ff").at(-280, 55, 8).build());
        world.add(
                ItemDefinition.named("ground")
                        .shape(Shape.plane(2000, 2000))
                        .colour("#808080")
                        .build());
        Picture picture = draw(world, Optional.empty());
        assertThat(picture.count(rgb -> isMostly(rgb, 16))).isGreaterThan(50);
        assertThat(picture.count(rgb -> isMostly(rgb, 0))).isGreaterThan(50);
    }

    @Test
    void boundsLeavePlanesAndShapelessBodiesOut() {
        World world = world("si-f64");
        world.add(ItemDefinition.named("ground").shape(Shape.plane(60, 40)).build());
        world.add(ItemDefinition.named("place").at(1000, 0, 0).build());
        try (WorldSnapshot snapshot = snapshot(world)) {
            assertThat(SceneBuilder.bounds(snapshot))
                    .contains(new Bounds(new Point(-30, 0, -20), new Point(30, 0, 20)));
        }
        world.add(ball("red", "#ff0000").at(3, 4, 5).build());
        try (WorldSnapshot snapshot = snapshot(world)) {
            assertThat(SceneBuilder.bounds(snapshot))
                    .contains(new Bounds(new Point(2, 3, 4), new Point(4, 5, 6)));
        }
    }

    @Test
    void aWorldWithoutPlanesStandsOverAGround() {
        World world = world("si-f64");
        assertThat(build(world, Optional.empty()).instances(Shape.PLANE).count()).isEqualTo(1);
        world.add(ItemDefinition.named("ground").shape(Shape.plane(60, 40)).build());
        world.add(ItemDefinition.named("table").shape(Shape.plane(1, 1)).at(0, 1, 0).build());
        assertThat(build(world, Optional.empty()).instances(Shape.PLANE).count()).isEqualTo(2);
    }

    @Test
    void aLostSnapshotGivesNoScene() {
        World world = world("si-f64");
        world.add(ball("red", "#ff0000").build());
        new BoundingBoxes().update(world);
        var ring = new SnapshotRing(world, 2);
        ring.publish(1, 0);
        try (WorldSnapshot old = ring.acquireLatest().orElseThrow()) {
            for (int frame = 2; !old.lost(); frame++) {
                ring.publish(frame, 0);
                ring.acquireLatest().orElseThrow(); // kept, so that no slot is free
            }
            assertThatExceptionOfType(RenderException.class)
                    .isThrownBy(() -> new SceneBuilder(SMALL, FLAT, Optional.empty()).build(old))
                    .withMessageContaining("frame 1 was overwritten");
        }
    }

    private static void spring(World world, String name, String end, ConnectionLook look) {
        world.add(
                ItemDefinition.named(name)
                        .kind("spring")
                        .look(look)
                        .physics("length", 1)
                        .reference("end1", "origin")
                        .reference("end2", end)
                        .build());
    }

    private static ConnectionLook look(String colour, double width) {
        return new ConnectionLook(Optional.of(Colour.parse(colour)), width);
    }

    @Test
    void springsHaveTheirColourAndWidthAndHiddenOnesNoPixels() {
        World world = world("si-f64");
        world.add(ItemDefinition.named("origin").at(-5, 0, 0).physics("mass", 1).build());
        world.add(ItemDefinition.named("right").at(5, 0, 0).physics("mass", 1).build());
        world.add(ItemDefinition.named("up").at(-5, 8, 0).physics("mass", 1).build());
        world.add(ItemDefinition.named("down").at(-5, -8, 0).physics("mass", 1).build());
        spring(world, "rod", "right", look("#ff0000", 2));
        spring(world, "line", "up", look("#00ff00", 0));
        spring(world, "hidden rod", "down", look("#0000ff00", 2));
        spring(world, "hidden line", "down", look("#0000ff00", 0));
        Picture picture = draw(world, Optional.of(FRONT));
        assertThat(isMostly(picture.at(100, 92), 16)).as("0.8 m above the axis").isTrue();
        assertThat(isMostly(picture.at(100, 108), 16)).as("0.8 m below the axis").isTrue();
        assertThat(picture.at(100, 85)).as("above the rod").isZero();
        assertThat(picture.at(155, 100)).as("behind its end").isZero();
        assertThat(isMostly(picture.at(50, 50), 8)).isTrue();
        assertThat(picture.at(55, 50)).as("beside the line").isZero();
        assertThat(picture.count(rgb -> isMostly(rgb, 0))).isZero();
        assertThat(picture.at(50, 150)).as("where a hidden spring is").isZero();

        world.find("rod").orElseThrow().physical().setColour(Colour.parse("#0000ff"));
        world.find("rod").orElseThrow().physical().setWidth(4);
        Picture changed = draw(world, Optional.of(FRONT));
        assertThat(isMostly(changed.at(100, 83), 0)).as("1.7 m above the axis").isTrue();
    }

    @Test
    void aSurfaceWithAColourOfItsOwnIsShownInIt() {
        World world = world("si-f64");
        world.add(corner("a", "#ff000000").at(-5, -5, 0).build());
        world.add(corner("b", "#00ff0000").at(5, -5, 0).build());
        world.add(corner("c", "#ff0000").at(0, 5, 0).build());
        surface(world, "face", look("#0000ff", 0));
        Picture picture = draw(world, Optional.of(FRONT));
        assertThat(isMostly(picture.at(100, 120), 0)).isTrue();
        assertThat(isMostly(picture.at(100, 57), 0)).as("at the red corner").isTrue();

        world.find("face").orElseThrow().physical().setColour(Colour.parse("#0000ff00"));
        assertThat(draw(world, Optional.of(FRONT)).count(rgb -> isMostly(rgb, 0))).isZero();
    }

    private static void surface(World world, String name, ConnectionLook look) {
        world.add(
                ItemDefinition.named(name)
                        .kind("surface")
                        .look(look)
                        .physics("hardness", 1)
                        .reference("vertices", "a", "b", "c")
                        .build());
    }
}
