// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.Arguments;
import org.junit.jupiter.params.provider.MethodSource;
import org.junit.jupiter.params.provider.ValueSource;

import java.lang.foreign.ValueLayout;
import java.util.List;
import java.util.stream.Stream;

/** Shapes follow the sizes that laws wrote into the column, which are no edits. */
class LawSizesTest {
    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());

    private Item body(String name, Shape shape) {
        return world.add(ItemDefinition.named(name).shape(shape).physics("mass", 1).build());
    }

    /** Writes a size as a law does: into the memory of the column. */
    private void write(Item item, double... size) {
        Table bodies = world.table("body");
        for (int axis = 0; axis < 3; axis++) {
            bodies.column("size")
                    .segment()
                    .setAtIndex(
                            ValueLayout.JAVA_DOUBLE,
                            3L * bodies.rowOf(item.id()) + axis,
                            size[axis]);
        }
    }

    private static Mesh triangle() {
        return new Mesh(new float[] {0, 0, 0, 2, 0, 0, 0, 3, 0}, new int[] {0, 1, 2});
    }

    static Stream<Arguments> shapes() {
        return Stream.of(
                Arguments.of(Shape.sphere(1), List.of(3.0, 8.0, 0.0), Shape.sphere(1.5)),
                Arguments.of(Shape.box(1, 1, 1), List.of(3.0, 8.0, 0.5), Shape.box(3, 8, 0.5)),
                Arguments.of(Shape.plane(1, 1), List.of(3.0, 8.0, 0.5), Shape.plane(3, 0.5)),
                Arguments.of(Shape.plane(1, 1), List.of(3.0, -0.0, 0.5), Shape.plane(3, 0.5)),
                Arguments.of(Shape.capsule(1, 3), List.of(3.0, 8.0, 0.0), Shape.capsule(1.5, 8)),
                Arguments.of(Shape.capsule(1, 3), List.of(3.0, 2.0, 0.0), Shape.capsule(1.5, 3)),
                Arguments.of(Shape.cylinder(1, 3), List.of(3.0, 2.0, 9.0), Shape.cylinder(1.5, 2)),
                Arguments.of(
                        Shape.ellipsoid(1, 2, 3), List.of(3.0, 2.0, 9.0), Shape.ellipsoid(3, 2, 9)),
                Arguments.of(Shape.none(), List.of(3.0, 2.0, 9.0), Shape.none()),
                Arguments.of(triangle(), List.of(3.0, 2.0, 9.0), triangle()));
    }

    @ParameterizedTest
    @MethodSource("shapes")
    void aShapeTakesThoseNumbersThatItHas(Shape before, List<Double> written, Shape after) {
        Item item = body("item", before);
        write(item, written.stream().mapToDouble(Double::doubleValue).toArray());
        assertThat(FrameControl.of(world).followSizes()).isEmpty();
        Shape found = item.physical().shape();
        assertThat(found.code()).isEqualTo(after.code());
        for (int axis = 0; axis < 3; axis++) {
            assertThat(found.size(axis)).isEqualTo(after.size(axis));
            assertThat(Double.doubleToRawLongBits(item.physical().size()[axis]))
                    .as("number %d of the column", axis)
                    .isEqualTo(Double.doubleToRawLongBits(after.size(axis)));
        }
        assertThat(world.table("body").shapeAt(0)).isSameAs(found);
        assertThat(world.symbols().get(item.id()).shape()).isSameAs(found);
    }

    @Test
    void theChangeIsNoEdit() {
        Item ball = body("ball", Shape.sphere(1));
        FrameControl.of(world).publish();
        FrameControl.of(world).end();
        long version = world.table("body").column("size").version();
        write(ball, 4, 4, 4);
        FrameControl.of(world).followSizes();
        assertThat(ball.physical().shape()).isEqualTo(Shape.sphere(2));
        assertThat(ball.semantic().get("dimensions")).contains(List.of(4.0, 4.0, 4.0));
        assertThat(world.changes()).isEmpty();
        assertThat(world.table("body").column("size").version()).isEqualTo(version);
    }

    /** The engine reads the column again after numbers were set back. */
    @Test
    void numbersThatAreSetBackRaiseTheVersionOfTheColumn() {
        Item ball = body("ball", Shape.sphere(1));
        long version = world.table("body").column("size").version();
        write(ball, 4, 5, 6);
        FrameControl.of(world).followSizes();
        assertThat(world.table("body").column("size").version()).isGreaterThan(version);
    }

    @Test
    void whatDoesNotChangeKeepsItsObjects() {
        Item ball = body("ball", Shape.sphere(1));
        Item box = body("box", Shape.box(1, 2, 3));
        var before = world.symbols();
        assertThat(FrameControl.of(world).followSizes()).isEmpty();
        assertThat(world.symbols()).isSameAs(before);
        write(ball, 4, 4, 4);
        FrameControl.of(world).followSizes();
        assertThat(world.symbols().get(box.id())).isSameAs(before.get(box.id()));
    }

    /** 1e-101 m is less than a world file may contain, so a saved world could not be loaded. */
    @ParameterizedTest
    @ValueSource(doubles = {0, -1, 1e-101, 1e13})
    void aSizeThatTheShapeCannotHaveIsRefusedAndSetBack(double length) {
        Item first = body("first", Shape.sphere(1));
        Item second = body("second", Shape.box(1, 2, 3));
        Item third = body("third", Shape.sphere(2));
        write(second, 4, length, 4);
        write(third, length, 4, 4);
        write(first, 6, 6, 6);
        RefusedSize refused = FrameControl.of(world).followSizes().orElseThrow();
        assertThat(refused.item()).isSameAs(second);
        assertThat(refused.size()).containsExactly(4.0, length, 4.0);
        assertThat(second.physical().shape()).isEqualTo(Shape.box(1, 2, 3));
        assertThat(second.physical().size()).containsExactly(1, 2, 3);
        assertThat(third.physical().size()).containsExactly(4, 4, 4);
        assertThat(first.physical().shape()).isEqualTo(Shape.sphere(3));
    }

    @Test
    void sceneryKeepsItsShapeBecauseLawsDoNotSeeItsRow() {
        Item ball = body("ball", Shape.sphere(1));
        Item wall = world.add(ItemDefinition.named("wall").shape(Shape.box(1, 2, 3)).build());
        write(ball, 4, 4, 4);
        FrameControl.of(world).followSizes();
        assertThat(wall.physical().shape()).isEqualTo(Shape.box(1, 2, 3));
        assertThat(wall.physical().size()).containsExactly(1, 2, 3);
    }

    @Test
    void anImageContinuesWithTheShapesThatLawsMade() {
        Item ball = body("ball", Shape.sphere(1));
        write(ball, 4, 4, 4);
        FrameControl.of(world).followSizes();
        try (WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, 1);
            World other = new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
            other.restore(image);
            assertThat(other.find("ball").orElseThrow().physical().shape())
                    .isEqualTo(Shape.sphere(2));
            assertThat(FrameControl.of(other).followSizes()).isEmpty();
            write(ball, 5, 5, 5);
            FrameControl.of(world).followSizes();
            world.restore(image);
            assertThat(ball.physical().shape()).isEqualTo(Shape.sphere(2));
        }
    }

    @Test
    void anInspectionRefusesTheChange() {
        body("ball", Shape.sphere(1));
        assertThatIllegalStateException()
                .isThrownBy(
                        () ->
                                world.guard()
                                        .inspect(
                                                "action look",
                                                () -> FrameControl.of(world).followSizes()))
                .withMessageContaining("action look");
    }
}
