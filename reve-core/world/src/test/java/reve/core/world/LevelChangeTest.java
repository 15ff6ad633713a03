// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.assertj.core.data.Offset;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Changes of levels: what they hand over, in closed form, and what they refuse. */
class LevelChangeTest {
    private static final Offset<Double> ROUNDING = within(1e-13);
    private static final double MASS = 2;
    private static final double RADIUS = 0.3;

    /** Moment of inertia of a solid ball [kg*m^2]. */
    private static final double MOMENT = 0.4 * MASS * RADIUS * RADIUS;

    /** Half edges of the mesh, which has a mass point at each corner of a box [m]. */
    private static final double[] HALF = {0.2, 0.3, 0.4};

    /** Moments of inertia of these eight mass points [kg*m^2]: M (b² + c²), and so on. */
    private static final double[] MOMENTS = {
        MASS * (0.09 + 0.16), MASS * (0.04 + 0.16), MASS * (0.04 + 0.09)
    };

    private static final double[] PLACE = {1, 2, 3};
    private static final double[] VELOCITY = {3, -1, 2};
    private static final double[] SPIN = {0.5, 4, -2};

    /** A rotation by 1.1 rad about the axis (1, 2, -2)/3. */
    private static final double[] TURN = {
        Math.sin(0.55) / 3, Math.sin(0.55) * 2 / 3, -Math.sin(0.55) * 2 / 3, Math.cos(0.55)
    };

    private final OffHeapArena arena = new OffHeapArena();
    private World world;
    private Item drop;

    @BeforeEach
    void build() {
        world = new World("w", WorldPrototype.standard("si-f64"), arena);
        drop = world.add(ball("drop", List.of(ballLevel(), mesh(), point(), block())));
    }

    @AfterEach
    void close() {
        arena.close();
    }

    private static ItemDefinition.Builder solid(String name) {
        return ItemDefinition.named(name)
                .shape(Shape.sphere(RADIUS))
                .physics("mass", MASS)
                .physics("radius", RADIUS)
                .physics("inertia", MOMENT, MOMENT, MOMENT);
    }

    private static ItemDefinition ball(String name, List<Level> levels) {
        return solid(name)
                .at(PLACE[0], PLACE[1], PLACE[2])
                .orientation(TURN[0], TURN[1], TURN[2], TURN[3])
                .physics("velocity", VELOCITY)
                .physics("angularVelocity", SPIN)
                .symbol("level", "ball")
                .levels(levels)
                .build();
    }

    private static Level ballLevel() {
        return new Level("ball", false, List.of(solid("any").build()), Optional.empty());
    }

    private static Level mesh() {
        List<ItemDefinition> parts = new ArrayList<>();
        for (int i = 0; i < 8; i++) {
            double[] at = corner(i);
            parts.add(
                    ItemDefinition.named("knot " + i)
                            .at(at[0], at[1], at[2])
                            .physics("mass", MASS / 8)
                            .build());
        }
        for (int i = 1; i < 8; i++) {
            parts.add(
                    ItemDefinition.named("string " + i)
                            .kind("spring")
                            .physics("springConstant", 100)
                            .reference("end1", "knot 0")
                            .reference("end2", "knot " + i)
                            .build());
        }
        return new Level("mesh", true, parts, Optional.empty());
    }

    private static double[] corner(int i) {
        return new double[] {
            (i & 1) == 0 ? -HALF[0] : HALF[0],
            (i & 2) == 0 ? -HALF[1] : HALF[1],
            (i & 4) == 0 ? -HALF[2] : HALF[2]
        };
    }

    private static Level point() {
        return new Level(
                "point",
                false,
                List.of(ItemDefinition.named("any").physics("mass", MASS).build()),
                Optional.empty());
    }

    /** A single rigid box, which is turned within the item and beside its origin. */
    private static Level block() {
        return new Level(
                "block",
                true,
                List.of(
                        ItemDefinition.named("box")
                                .at(5, 0, 0)
                                .orientation(0, 0, Math.sin(0.4), Math.cos(0.4))
                                .physics("mass", MASS)
                                .physics("inertia", 0.1, 0.2, 0.15)
                                .build()),
                Optional.empty());
    }

    private WorldEvent change(String level) {
        LevelChange.prepare(world, drop, level).make(7);
        return world.events().getLast();
    }

    private Item part(String name) {
        return world.find("drop." + name).orElseThrow();
    }

    /** Rotates a vector by the quaternion q: q v q*. */
    private static double[] rotated(double[] q, double... v) {
        double[] t = {
            2 * (q[1] * v[2] - q[2] * v[1]),
            2 * (q[2] * v[0] - q[0] * v[2]),
            2 * (q[0] * v[1] - q[1] * v[0])
        };
        double[] c = cross(q, t);
        return new double[] {
            v[0] + q[3] * t[0] + c[0], v[1] + q[3] * t[1] + c[1], v[2] + q[3] * t[2] + c[2]
        };
    }

    private static double[] back(double[] q, double... v) {
        return rotated(new double[] {-q[0], -q[1], -q[2], q[3]}, v);
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }

    private static double[] scaled(double[] v, double k) {
        return new double[] {v[0] * k, v[1] * k, v[2] * k};
    }

    private static double square(double[] v) {
        return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    }

    private static void assertClose(double[] found, double[] expected) {
        for (int i = 0; i < expected.length; i++) {
            assertThat(found[i]).as("component %d", i).isCloseTo(expected[i], ROUNDING);
        }
    }

    private static double number(WorldEvent event, String field) {
        return ((Number) event.fields().get(field)).doubleValue();
    }

    private static double[] vector(WorldEvent event, String field) {
        String[] texts = event.fields().get(field).toString().replaceAll("[\\[\\]]", "").split(",");
        return new double[] {
            Double.parseDouble(texts[0]), Double.parseDouble(texts[1]), Double.parseDouble(texts[2])
        };
    }

    /** Angular velocity of the mesh in its own axes: L / I for each principal axis. */
    private static double[] spinOfMesh() {
        double[] own = back(TURN, scaled(SPIN, MOMENT));
        return new double[] {own[0] / MOMENTS[0], own[1] / MOMENTS[1], own[2] / MOMENTS[2]};
    }

    private static double energyOfMesh() {
        double[] spin = spinOfMesh();
        return (MASS * square(VELOCITY)
                        + MOMENTS[0] * spin[0] * spin[0]
                        + MOMENTS[1] * spin[1] * spin[1]
                        + MOMENTS[2] * spin[2] * spin[2])
                / 2;
    }

    private static double energyOfBall() {
        return (MASS * square(VELOCITY) + MOMENT * square(SPIN)) / 2;
    }

    @Test
    void aSpinningFlyingBallBecomesAMeshThatMovesAsARigidBody() {
        WorldEvent event = change("mesh");
        for (int i = 0; i < 8; i++) {
            double[] at = rotated(TURN, corner(i));
            double[] turning = rotated(TURN, cross(spinOfMesh(), corner(i)));
            for (int axis = 0; axis < 3; axis++) {
                at[axis] += PLACE[axis];
                turning[axis] += VELOCITY[axis];
            }
            assertClose(part("knot " + i).physical().location(), at);
            assertClose(part("knot " + i).physics().vector("velocity"), turning);
        }
        assertThat(part("string 3").physics().reference("end2")).isEqualTo(part("knot 3").id());
        assertThat(drop.semantic().get("level")).contains("mesh");
        assertThat(drop.physics().isEmpty()).isTrue();
        assertThat(drop.physical().shape()).isEqualTo(Shape.none());
        assertClose(drop.physical().location(), PLACE);
        assertClose(drop.physical().orientation(), TURN);

        assertThat(event.type()).isEqualTo("level-changed");
        assertThat(event.frame()).isEqualTo(7);
        assertThat(event.fields()).containsEntry("item", "drop").containsEntry("from", "ball");
        assertClose(vector(event, "momentumBefore"), scaled(VELOCITY, MASS));
        assertClose(vector(event, "momentumAfter"), scaled(VELOCITY, MASS));
        assertClose(vector(event, "angularMomentumBefore"), scaled(SPIN, MOMENT));
        assertClose(vector(event, "angularMomentumAfter"), scaled(SPIN, MOMENT));
        assertThat(number(event, "energyBefore")).isCloseTo(energyOfBall(), ROUNDING);
        assertThat(number(event, "energyAfter")).isCloseTo(energyOfMesh(), ROUNDING);
        assertThat(number(event, "energyLost"))
                .isCloseTo(energyOfBall() - energyOfMesh(), ROUNDING);
    }

    /** A mesh that breathes has energy, but no momentum, that a ball cannot have. */
    @Test
    void aMeshThatVibratesBecomesABallAndItsEnergyOfVibrationIsReported() {
        change("mesh");
        double breathing = 0.7;
        double vibration = 0;
        for (int i = 0; i < 8; i++) {
            double[] outwards = scaled(rotated(TURN, corner(i)), breathing);
            double[] velocity = part("knot " + i).physics().vector("velocity");
            part("knot " + i)
                    .physics()
                    .set(
                            "velocity",
                            velocity[0] + outwards[0],
                            velocity[1] + outwards[1],
                            velocity[2] + outwards[2]);
            vibration += MASS / 8 * square(outwards) / 2;
        }
        assertThat(LevelChange.motion(world, drop).vibration()).isCloseTo(vibration, ROUNDING);
        WorldEvent event = change("ball");
        assertThat(number(event, "energyLost"))
                .isCloseTo(energyOfMesh() + vibration - energyOfBall(), ROUNDING);
        assertThat(world.items()).extracting(Item::name).containsExactly("world", "drop");
        assertThat(drop.parent()).isEmpty();
        assertThat(drop.physical().shape()).isEqualTo(Shape.sphere(RADIUS));
        assertThat(drop.physics().scalar("radius")).isEqualTo(RADIUS);
        assertThat(drop.physics().scalar("mass")).isCloseTo(MASS, ROUNDING);
        assertClose(drop.physical().location(), PLACE);
        assertClose(drop.physical().orientation(), TURN);
        assertClose(drop.physics().vector("velocity"), VELOCITY);
        assertClose(drop.physics().vector("angularVelocity"), SPIN);
    }

    /** The orientation of a mesh is that of its best rigid fit. */
    @Test
    void aMeshThatTurnedAndStretchedKeepsItsOrientation() {
        change("mesh");
        double[] further = {0, Math.sin(0.8), 0, Math.cos(0.8)};
        for (int i = 0; i < 8; i++) {
            double[] stretched = corner(i);
            stretched[1] *= 1.4;
            double[] at = rotated(further, rotated(TURN, stretched));
            part("knot " + i).physical().setLocation(at[0] - 4, at[1] + 1, at[2]);
        }
        change("ball");
        assertClose(drop.physical().location(), new double[] {-4, 1, 0});
        for (int axis = 0; axis < 3; axis++) {
            double[] unit = new double[3];
            unit[axis] = 1;
            assertClose(
                    rotated(drop.physical().orientation(), unit),
                    rotated(further, rotated(TURN, unit)));
        }
    }

    /** A point mass cannot spin. The event shows the angular momentum and energy that are gone. */
    @Test
    void aPointMassKeepsTheMomentumOnly() {
        WorldEvent event = change("point");
        assertClose(drop.physics().vector("velocity"), VELOCITY);
        assertClose(drop.physics().vector("angularVelocity"), new double[3]);
        assertThat(drop.physics().scalar("radius")).isZero();
        assertThat(drop.physical().shape()).isEqualTo(Shape.none());
        assertClose(vector(event, "angularMomentumAfter"), new double[3]);
        assertThat(number(event, "energyLost")).isCloseTo(MOMENT * square(SPIN) / 2, ROUNDING);
    }

    /** A change from one group to another also hands over the orientation of rigid parts. */
    @Test
    void aRigidPartTakesOverFromAMeshAndHandsBack() {
        change("mesh");
        change("block");
        assertThat(world.items())
                .extracting(Item::name)
                .containsExactly("world", "drop", "drop.box");
        Item box = part("box");
        assertClose(box.physical().location(), PLACE);
        double[] own = {0, 0, Math.sin(0.4), Math.cos(0.4)};
        assertClose(
                rotated(box.physical().orientation(), 1, 2, 3),
                rotated(TURN, rotated(own, 1, 2, 3)));
        assertClose(box.physics().vector("velocity"), VELOCITY);
        double[] inBox = back(own, back(TURN, scaled(SPIN, MOMENT)));
        double[] spin = {inBox[0] / 0.1, inBox[1] / 0.2, inBox[2] / 0.15};
        assertClose(box.physics().vector("angularVelocity"), rotated(TURN, rotated(own, spin)));
        change("ball");
        assertClose(drop.physical().location(), PLACE);
        assertClose(drop.physical().orientation(), TURN);
        assertClose(drop.physics().vector("angularVelocity"), SPIN);
    }

    @Test
    void aMassThatChangedIsKept() {
        drop.physics().set("mass", 5 * MASS);
        WorldEvent event = change("mesh");
        assertThat(part("knot 2").physics().scalar("mass")).isCloseTo(5 * MASS / 8, ROUNDING);
        assertThat(number(event, "mass")).isCloseTo(5 * MASS, ROUNDING);
        assertClose(vector(event, "momentumAfter"), scaled(VELOCITY, 5 * MASS));
        change("ball");
        assertThat(drop.physics().scalar("mass")).isCloseTo(5 * MASS, ROUNDING);
        assertClose(drop.physics().vector("velocity"), VELOCITY);
    }

    @Test
    void theActiveLevelChangesNothing() {
        List<WorldChange> before = world.changes();
        LevelChange.prepare(world, drop, "ball").make(1);
        assertThat(world.changes()).isEqualTo(before);
    }

    @Test
    void anotherItemThatRefersToTheItemOrToAPartHoldsTheLevel() {
        world.add(ItemDefinition.named("hook").physics("mass", 0).build());
        Item rope = world.add(rope("rope", "drop"));
        refuses("mesh", "keeps its level ball, because item rope");
        change("point");
        world.remove(rope.id());
        change("mesh");
        Item other = world.add(rope("other rope", "drop.knot 3"));
        refuses("ball", "keeps its level mesh, because item other rope");
        world.remove(other.id());
        Item flag = world.add(ItemDefinition.named("flag").parent("drop.knot 1").build());
        refuses("ball", "because item flag");
        world.remove(flag.id());
        change("ball");
    }

    private static ItemDefinition rope(String name, String end) {
        return ItemDefinition.named(name)
                .kind("spring")
                .reference("end1", "hook")
                .reference("end2", end)
                .build();
    }

    private void refuses(String level, String... reason) {
        List<WorldChange> before = world.changes();
        assertThatIllegalArgumentException()
                .isThrownBy(() -> LevelChange.prepare(world, drop, level))
                .withMessageContainingAll(reason);
        assertThat(world.changes()).isEqualTo(before);
    }

    @Test
    void unknownLevelsTakenNamesAndMissingPartsAreRefused() {
        refuses("messh", "has no level messh; its levels are ball, mesh", "did you mean `mesh`?");
        Item taken = world.add(ItemDefinition.named("drop.knot 5").build());
        refuses("mesh", "the name drop.knot 5 of a part of the level mesh is taken");
        world.remove(taken.id());
        drop.physics().set("mass", 0);
        refuses("mesh", "has no mass now");
        drop.physics().set("mass", MASS);
        change("mesh");
        world.remove(part("string 4").id());
        refuses("ball", "the part drop.string 4 of the level mesh is missing");
    }

    /** The symbol alone would say a level at which the item is not. */
    @Test
    void theSymbolOfTheLevelIsNotSetAlone() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> drop.semantic().set("level", "mesh"))
                .withMessageContaining("only a change of the level changes");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> drop.semantic().remove("level"))
                .withMessageContaining("level");
        Item plain = world.add(ItemDefinition.named("plain").build());
        plain.semantic().set("level", "high");
        assertThat(plain.semantic().symbols()).containsAllEntriesOf(Map.of("level", "high"));
    }

    /** A renamed item still finds its parts. */
    @Test
    void anItemMayBeRenamedBetweenChanges() {
        change("mesh");
        world.rename(drop.id(), "blob");
        change("ball");
        change("mesh");
        assertThat(world.find("blob.knot 7")).isPresent();
        assertThat(world.find("drop.knot 7")).isEmpty();
    }
}
