// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Random;

/** Random histories of attaching, moving and removing, compared with 4 x 4 matrices. */
class HierarchyModelTest {

    /**
     * A body in the oracle. It has an affine matrix (row-major 4 x 4) in the frame of its parent.
     */
    private static final class Node {
        private final Item item;
        private Node parent;
        private double[] own;

        Node(Item item, double[] own) {
            this.item = item;
            this.own = own;
        }

        double[] inWorld() {
            return parent == null ? own : multiply(parent.inWorld(), own);
        }

        boolean movesWith(Node other) {
            return this == other || parent != null && parent.movesWith(other);
        }
    }

    private final List<Node> nodes = new ArrayList<>();
    private Random random = new Random();
    private World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private int named;

    @ParameterizedTest
    @CsvSource({"si-f64, 21, 1e-9", "si-f32, 22, 1e-2", "si-f64, 0, 1e-9"})
    void agreesWithMatrices(String prototype, long givenSeed, double tolerance) {
        long seed = Seed.of("hierarchies in " + prototype, givenSeed);
        random = new Random(seed);
        world = new World("w", WorldPrototype.standard(prototype), new OffHeapArena());
        for (int step = 0; step < 800; step++) {
            change();
            if (step % 5 == 0) {
                FrameControl.of(world).placeAttached();
                check("seed " + seed + " step " + step, tolerance);
            }
        }
    }

    private void change() {
        switch (nodes.size() < 3 ? 0 : random.nextInt(8)) {
            case 0, 1 -> add();
            case 2, 3 -> attach();
            case 4 -> detach();
            case 5, 6 -> move();
            default -> remove();
        }
    }

    private void add() {
        double[] at = random.doubles(3, -10, 10).toArray();
        double[] q = quaternion();
        var definition =
                ItemDefinition.named("n" + named++)
                        .at(at[0], at[1], at[2])
                        .orientation(q[0], q[1], q[2], q[3]);
        Node parent = nodes.isEmpty() || random.nextBoolean() ? null : any();
        if (parent != null) {
            definition.parent(parent.item.name());
        }
        if (random.nextBoolean()) {
            definition.physics("mass", 0);
        }
        Node node = new Node(world.add(definition.build()), matrix(at, q));
        node.parent = parent;
        nodes.add(node);
    }

    private void attach() {
        Node child = any();
        Node parent = any();
        if (parent.movesWith(child)) {
            return;
        }
        if (random.nextBoolean()) {
            double[] at = random.doubles(3, -10, 10).toArray();
            double[] q = quaternion();
            world.attach(child.item.id(), parent.item.id(), Pose.of(at, q));
            child.own = matrix(at, q);
        } else {
            double[] before = child.inWorld();
            world.attach(child.item.id(), parent.item.id());
            child.own = multiply(inverse(parent.inWorld()), before);
        }
        child.parent = parent;
    }

    private void detach() {
        Node child = any();
        if (child.parent != null) {
            child.own = child.inWorld();
            child.parent = null;
            world.detach(child.item.id());
        }
    }

    private void move() {
        Node node = any();
        double[] at = random.doubles(3, -10, 10).toArray();
        double[] q = quaternion();
        node.item.physical().setLocation(at[0], at[1], at[2]);
        node.item.physical().setOrientation(q[0], q[1], q[2], q[3]);
        node.own =
                node.parent == null
                        ? matrix(at, q)
                        : multiply(inverse(node.parent.inWorld()), matrix(at, q));
    }

    private void remove() {
        Node node = any();
        world.removeCascade(node.item.id());
        nodes.removeIf(other -> other.movesWith(node));
    }

    private void check(String when, double tolerance) {
        assertThat(world.items()).as(when).hasSize(nodes.size() + 1);
        Table bodies = world.table("body");
        for (Node node : nodes) {
            double[] expected = node.inWorld();
            int row = bodies.rowOf(node.item.id());
            double[] at = new double[3];
            double[] q = new double[4];
            for (int i = 0; i < 3; i++) {
                at[i] = bodies.column("position").getDouble(row, i);
            }
            for (int i = 0; i < 4; i++) {
                q[i] = bodies.column("orientation").getDouble(row, i);
            }
            assertThat(matrix(at, q))
                    .as(when + " " + node.item)
                    .containsExactly(expected, within(tolerance));
            assertThat(node.item.physical().location()).as(when).containsExactly(at);
            assertThat(node.item.physical().orientation()).as(when).containsExactly(q);
            assertThat(node.item.parent())
                    .as(when)
                    .isEqualTo(Optional.ofNullable(node.parent).map(parent -> parent.item.id()));
        }
    }

    private Node any() {
        return nodes.get(random.nextInt(nodes.size()));
    }

    private double[] quaternion() {
        double[] q = random.doubles(4, -1, 1).toArray();
        double length = Math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        return length < 0.1
                ? new double[] {0, 0, 0, 1}
                : new double[] {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
    }

    private static double[] matrix(double[] at, double[] q) {
        double x = q[0];
        double y = q[1];
        double z = q[2];
        double w = q[3];
        return new double[] {
            1 - 2 * (y * y + z * z),
            2 * (x * y - z * w),
            2 * (x * z + y * w),
            at[0],
            2 * (x * y + z * w),
            1 - 2 * (x * x + z * z),
            2 * (y * z - x * w),
            at[1],
            2 * (x * z - y * w),
            2 * (y * z + x * w),
            1 - 2 * (x * x + y * y),
            at[2],
            0,
            0,
            0,
            1
        };
    }

    private static double[] multiply(double[] a, double[] b) {
        double[] c = new double[16];
        for (int i = 0; i < 16; i++) {
            for (int k = 0; k < 4; k++) {
                c[i] += a[i / 4 * 4 + k] * b[4 * k + i % 4];
            }
        }
        return c;
    }

    /** The matrix of a rotation and a translation. */
    private static double[] inverse(double[] m) {
        double[] out = new double[16];
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                out[4 * i + k] = m[4 * k + i];
                out[4 * i + 3] -= m[4 * k + i] * m[4 * k + 3];
            }
        }
        out[15] = 1;
        return out;
    }
}
