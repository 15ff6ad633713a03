// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Comparator;
import java.util.HashSet;
import java.util.List;
import java.util.Objects;
import java.util.Set;
import java.util.TreeSet;

/**
 * Which bodies move with which, and where that puts them. An attached item's pose in its parent's
 * frame is part of its symbols; its rows of {@code position} and {@code orientation}, in the world
 * frame, follow from it.
 */
final class Hierarchy {

    private final Column positions;
    private final Column orientations;
    private final boolean single;
    private final Activity activity;
    private final Set<Item> attached = new TreeSet<>(Comparator.comparing(Item::id));
    private final double[] pose = new double[Pose.NUMBERS];

    /** Attached items with parents before children, and their own poses; empty if to be redone. */
    private final List<Item> order = new ArrayList<>();

    private double[] relative = {};
    private boolean current = true;

    /**
     * @param activity counts a step for each level that is walked up
     */
    Hierarchy(Table bodies, Activity activity) {
        this.activity = activity;
        positions = bodies.column("position");
        orientations = bodies.column("orientation");
        single = positions.type() == ScalarType.F32;
    }

    /**
     * @throws IllegalArgumentException if the two cannot move together
     */
    void requireAttachable(Item child, Item parent) {
        String where = child + " cannot be attached to " + parent + ": ";
        requireBody(where, child.name(), child.kind());
        requireBody(where, parent.name(), parent.kind());
        requireNoMass(
                where, child.physics().isEmpty() ? 0 : child.physics().scalar(PhysicsAspect.MASS));
        for (Item above = parent; above != null; above = above.parent) {
            if (above == child) {
                throw new IllegalArgumentException(
                        where
                                + (parent == child
                                        ? "it is the same item"
                                        : parent.name() + " already moves with " + child.name()));
            }
        }
    }

    static void requireBody(String where, String name, String kind) {
        if (!kind.equals(WorldPrototype.BODY)) {
            throw new IllegalArgumentException(
                    where
                            + name
                            + " is of kind "
                            + kind
                            + ", which has no place; only items of kind body have");
        }
    }

    static void requireNoMass(String where, double mass) {
        if (mass != 0) {
            throw new IllegalArgumentException(
                    where
                            + "mass is "
                            + mass
                            + " kg, but laws cannot move what moves with another item: "
                            + "give it mass 0, or hold it with a spring");
        }
    }

    /** Puts a child under a parent; its symbols say where. */
    void link(Item child, Item parent) {
        unlink(child);
        parent.addChild(child);
        attached.add(child);
    }

    void unlink(Item child) {
        if (child.parent != null) {
            child.parent.removeChild(child);
            attached.remove(child);
        }
        current = false;
    }

    /** Links all items of a restored world as their symbols say. */
    void restore(Collection<Item> items) {
        attached.clear();
        for (Item item : items) {
            item.parent = null;
            item.children = null;
        }
        for (Item item : items) {
            Attachment attachment = item.symbols().attachment();
            if (attachment != null) {
                link(item, item.world().item(attachment.parent()));
            }
        }
        current = false;
    }

    /** An item's pose in its parent's frame was changed. */
    void touch() {
        current = false;
    }

    /**
     * Where an item is now, whatever was moved since the last {@link #place()}: the numbers of a
     * pose in the world frame.
     */
    double[] worldPose(Item item) {
        List<Item> path = new ArrayList<>();
        Item root = item;
        for (; root.parent != null; root = root.parent) {
            path.add(root);
        }
        activity.spend(path.size());
        double[] result = new double[Pose.NUMBERS];
        read(root.row, result);
        for (Item next : path.reversed()) {
            Pose.compose(result, 0, next.attachment().pose().numbers(), 0, result, 0);
            round(result);
        }
        return result;
    }

    /** Writes where an attached item is now to its row. */
    void settle(Item item) {
        write(item, worldPose(item));
    }

    /** Puts new attached items where their parents have them, in whatever order they come. */
    void placeNew(List<Item> items) {
        Set<Item> waiting = new HashSet<>();
        for (Item item : items) {
            if (item.parent != null) {
                waiting.add(item);
            }
        }
        List<Item> path = new ArrayList<>();
        for (Item item : items) {
            for (Item next = item; next != null && waiting.remove(next); next = next.parent) {
                path.add(next);
            }
            path.reversed().forEach(next -> place(next, next.attachment().pose().numbers(), 0));
            path.clear();
        }
    }

    /** Puts all attached items where their parents have them; allocates only after changes. */
    void place() {
        if (!current) {
            sort();
        }
        for (int i = 0; i < order.size(); i++) {
            place(order.get(i), relative, i * Pose.NUMBERS);
        }
    }

    private void place(Item item, double[] own, int at) {
        read(Objects.requireNonNull(item.parent).row, pose);
        Pose.compose(pose, 0, own, at, pose, 0);
        write(item, pose);
    }

    private void write(Item item, double[] numbers) {
        boolean seenByLaws = item.row < item.table().physicsRowCount();
        for (int i = 0; i < 3; i++) {
            positions.derive(item.row, i, numbers[i], seenByLaws);
        }
        for (int i = 0; i < 4; i++) {
            orientations.derive(item.row, i, numbers[3 + i], seenByLaws);
        }
    }

    private void sort() {
        order.clear();
        for (Item item : attached) {
            if (item.parent != null && item.parent.parent == null) {
                order.add(item);
            }
        }
        for (int i = 0; i < order.size(); i++) {
            Set<Item> children = order.get(i).children;
            if (children != null) {
                order.addAll(children);
            }
        }
        if (relative.length < order.size() * Pose.NUMBERS) {
            relative = new double[2 * order.size() * Pose.NUMBERS];
        }
        for (int i = 0; i < order.size(); i++) {
            System.arraycopy(
                    order.get(i).attachment().pose().numbers(),
                    0,
                    relative,
                    i * Pose.NUMBERS,
                    Pose.NUMBERS);
        }
        current = true;
    }

    private void read(int row, double[] into) {
        for (int i = 0; i < 3; i++) {
            into[i] = positions.getDouble(row, i);
        }
        for (int i = 0; i < 4; i++) {
            into[3 + i] = orientations.getDouble(row, i);
        }
    }

    /** As the columns would keep it. */
    private void round(double[] numbers) {
        for (int i = 0; single && i < numbers.length; i++) {
            numbers[i] = (float) numbers[i];
        }
    }
}
