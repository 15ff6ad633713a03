// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Collection;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.NavigableMap;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;

/**
 * Attachments of bodies to parents. The symbolic data of an attached item contain its pose
 * (location and orientation) relative to the parent. Its rows of {@code position} and {@code
 * orientation} are in the world's reference frame and are computed from this pose. For the world's
 * thread only.
 */
final class Hierarchy {

    private final Table bodies;
    private final Column positions;
    private final Column orientations;
    private final boolean single;
    private final Layout layout;
    private final Activity activity;
    private final NavigableMap<ItemId, Attachment> attachments = new TreeMap<>();

    /** The items attached to each parent; contains no empty set. */
    private final Map<ItemId, TreeSet<ItemId>> children = new HashMap<>();

    private final double[] pose = new double[Pose.NUMBERS];

    /**
     * Attached items, with parents before their children. The list is valid only while {@link
     * #current} is true.
     */
    private final List<ItemId> order = new ArrayList<>();

    /** Poses of the attached items relative to their parents, in the order of {@link #order}. */
    private double[] relative = {};

    /**
     * (items x 2) the row of each attached item and the row of its parent, in the order of {@link
     * #order}.
     */
    private int[] rows = {};

    private boolean current = true;
    private long rowsVersion = -1;

    /**
     * @param layout layout of the tables; its version changes when rows have moved
     * @param activity counts an evaluation step for each level of parents
     */
    Hierarchy(Table bodies, Layout layout, Activity activity) {
        this.bodies = bodies;
        this.layout = layout;
        this.activity = activity;
        positions = bodies.column("position");
        orientations = bodies.column("orientation");
        single = positions.type() == ScalarType.F32;
    }

    /** Returns a copy of the ids of the items that are attached to an item, in ascending order. */
    List<ItemId> children(ItemId item) {
        TreeSet<ItemId> attached = children.get(item);
        return attached == null ? List.of() : List.copyOf(attached);
    }

    /**
     * Checks that a child can be attached to a parent.
     *
     * @throws IllegalArgumentException if the child cannot be attached to the parent
     */
    void requireAttachable(ItemSymbols child, ItemSymbols parent) {
        String where = child.label() + " cannot be attached to " + parent.label() + ": ";
        requireBody(where, child.name(), child.kind());
        requireBody(where, parent.name(), parent.kind());
        if (bodies.hasPhysics(child.id())) {
            Column masses = bodies.physicsColumn(WorldPrototype.MASS);
            requireNoMass(where, masses.getDouble(bodies.rowOf(child.id()), 0));
        }
        for (ItemId above = parent.id(); above != null; above = parentOf(above)) {
            if (above.equals(child.id())) {
                throw new IllegalArgumentException(
                        where
                                + (parent.id().equals(child.id())
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

    /** Attaches a child to a parent, or changes its pose relative to the parent. */
    void attach(ItemId child, Attachment attachment) {
        Attachment former = attachments.get(child);
        if (former != null && former.parent().equals(attachment.parent())) {
            attachments.put(child, attachment);
            current = false;
            return;
        }
        detach(child);
        layout.changed();
        attachments.put(child, attachment);
        children.computeIfAbsent(attachment.parent(), none -> new TreeSet<>()).add(child);
    }

    /** Detaches a child from its parent, if it has one. */
    void detach(ItemId child) {
        Attachment former = attachments.remove(child);
        if (former != null) {
            layout.changed();
            children.computeIfPresent(
                    former.parent(),
                    (parent, attached) -> {
                        attached.remove(child);
                        return attached.isEmpty() ? null : attached;
                    });
        }
        current = false;
    }

    /** Attaches all items of a restored world according to their symbolic data. */
    void restore(Collection<ItemSymbols> items) {
        attachments.clear();
        children.clear();
        for (ItemSymbols item : items) {
            if (item.attachment() != null) {
                attach(item.id(), item.attachment());
            }
        }
        current = false;
    }

    /**
     * Returns the present pose of an item in the world's reference frame, including moves since the
     * last {@link #place()}.
     */
    double[] worldPose(ItemId item) {
        List<Attachment> path = new ArrayList<>();
        ItemId root = item;
        for (Attachment next; (next = attachments.get(root)) != null; root = next.parent()) {
            path.add(next);
        }
        activity.spend(path.size());
        double[] result = new double[Pose.NUMBERS];
        read(bodies.rowOf(root), result);
        for (Attachment next : path.reversed()) {
            Pose.compose(result, 0, next.pose().numbers(), 0, result, 0);
            round(result);
        }
        return result;
    }

    /** Computes the present pose of an attached item, and writes it to the item's row. */
    void settle(ItemId item) {
        write(bodies.rowOf(item), worldPose(item));
    }

    /**
     * Computes the rows of new attached items from the rows of their parents. The list may have any
     * order.
     */
    void placeNew(List<ItemId> items) {
        Set<ItemId> waiting = new HashSet<>();
        for (ItemId item : items) {
            if (attachments.containsKey(item)) {
                waiting.add(item);
            }
        }
        if (waiting.isEmpty()) {
            return;
        }
        List<ItemId> path = new ArrayList<>();
        for (ItemId item : items) {
            for (ItemId next = item; next != null && waiting.remove(next); next = parentOf(next)) {
                path.add(next);
            }
            for (ItemId next : path.reversed()) {
                Attachment attachment = attachments.get(next);
                place(
                        bodies.rowOf(next),
                        bodies.rowOf(attachment.parent()),
                        attachment.pose().numbers(),
                        0);
            }
            path.clear();
        }
    }

    /**
     * Computes the rows of all attached items from the rows of their parents. Allocates memory only
     * after attachments have changed.
     */
    void place() {
        if (!current) {
            sort();
        }
        if (rowsVersion != layout.version()) {
            locate();
        }
        for (int i = 0; i < order.size(); i++) {
            place(rows[2 * i], rows[2 * i + 1], relative, i * Pose.NUMBERS);
        }
    }

    private void place(int row, int parentRow, double[] own, int at) {
        read(parentRow, pose);
        Pose.compose(pose, 0, own, at, pose, 0);
        write(row, pose);
    }

    private void write(int row, double[] numbers) {
        boolean seenByLaws = row < bodies.physicsRowCount();
        for (int i = 0; i < 3; i++) {
            positions.derive(row, i, numbers[i], seenByLaws);
        }
        for (int i = 0; i < 4; i++) {
            orientations.derive(row, i, numbers[3 + i], seenByLaws);
        }
    }

    private void sort() {
        order.clear();
        attachments.forEach(
                (item, attachment) -> {
                    if (!attachments.containsKey(attachment.parent())) {
                        order.add(item);
                    }
                });
        for (int i = 0; i < order.size(); i++) {
            TreeSet<ItemId> attached = children.get(order.get(i));
            if (attached != null) {
                order.addAll(attached);
            }
        }
        if (rows.length < 2 * order.size()) {
            relative = new double[2 * order.size() * Pose.NUMBERS];
            rows = new int[4 * order.size()];
        }
        for (int i = 0; i < order.size(); i++) {
            double[] own = attachments.get(order.get(i)).pose().numbers();
            System.arraycopy(own, 0, relative, i * Pose.NUMBERS, Pose.NUMBERS);
        }
        rowsVersion = -1;
        current = true;
    }

    private void locate() {
        for (int i = 0; i < order.size(); i++) {
            ItemId item = order.get(i);
            rows[2 * i] = bodies.rowOf(item);
            rows[2 * i + 1] = bodies.rowOf(attachments.get(item).parent());
        }
        rowsVersion = layout.version();
    }

    private @Nullable ItemId parentOf(ItemId item) {
        Attachment attachment = attachments.get(item);
        return attachment == null ? null : attachment.parent();
    }

    private void read(int row, double[] into) {
        for (int i = 0; i < 3; i++) {
            into[i] = positions.getDouble(row, i);
        }
        for (int i = 0; i < 4; i++) {
            into[3 + i] = orientations.getDouble(row, i);
        }
    }

    /** Rounds numbers to the precision of the columns. */
    private void round(double[] numbers) {
        for (int i = 0; single && i < numbers.length; i++) {
            numbers[i] = (float) numbers[i];
        }
    }
}
