// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.world.Colour;
import reve.core.world.Column;
import reve.core.world.ConnectionLook;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.Material;
import reve.core.world.Shape;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldChange;
import reve.core.world.WorldPrototype;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/**
 * A frame of the world, for a copy of the world that makes the same frame with other laws. It
 * contains all changes that laws did not cause, and the positions to which the laws moved the
 * bodies.
 *
 * @param early changes before the laws acted
 * @param late changes after the laws acted
 * @param positions positions of the bodies with physics at the end of the frame, in the column's
 *     type. The array is empty if there was no room for it; the copy is then not compared with the
 *     world in this frame.
 * @param velocities velocities of these bodies, in the same form
 * @param arrested items that stopped moving in this frame, because a law failed at them
 */
record ShadowFrame(
        List<Noted> early,
        List<Noted> late,
        byte[] positions,
        byte[] velocities,
        Set<ItemId> arrested) {
    static final String POSITION = "position";
    static final String VELOCITY = "velocity";

    /**
     * A change of the world. The field {@code columnRows} contains the rows of a column that was
     * edited directly, after the change. It is null for other changes.
     */
    record Noted(WorldChange change, byte @Nullable [] columnRows) {}

    /**
     * Returns the changes from an index on. For the world's thread, in the frame of the changes.
     */
    static List<Noted> noted(World world, List<WorldChange> changes, int from) {
        return changes.subList(from, changes.size()).stream()
                .map(change -> noted(world, change))
                .toList();
    }

    private static Noted noted(World world, WorldChange change) {
        return new Noted(
                change,
                change instanceof WorldChange.ColumnEdited edited
                        ? world.table(edited.kind())
                                .column(edited.property())
                                .segment()
                                .toArray(ValueLayout.JAVA_BYTE)
                        : null);
    }

    /** Returns the memory of a column's rows with physics. */
    static MemorySegment rows(World world, String property) {
        Table bodies = world.table(WorldPrototype.BODY);
        Column column = bodies.column(property);
        return column.segment()
                .asSlice(0, (long) bodies.physicsRowCount() * column.descriptor().rowBytes());
    }

    /** Returns whether the frame contains the positions of the world's bodies. */
    boolean hasRows() {
        return positions.length > 0;
    }

    /** Returns the memory of positions and velocities [bytes]. */
    long rowBytes() {
        return positions.length + (long) velocities.length;
    }

    /** Returns the memory that the frame needs [bytes]. */
    long bytes() {
        long columns = 0;
        for (List<Noted> changes : List.of(early, late)) {
            for (Noted noted : changes) {
                columns += noted.columnRows == null ? 0 : noted.columnRows.length;
            }
        }
        return columns + positions.length + velocities.length;
    }

    /**
     * Makes changes in the copy. For the copy's thread, between frames. Symbols and actions are not
     * changed, because laws do not use them.
     */
    static void repeat(World world, List<Noted> changes) {
        changes.forEach(noted -> repeat(world, noted));
    }

    private static void repeat(World world, Noted noted) {
        switch (noted.change) {
            case WorldChange.Added added ->
                    world.addAll(added.definitions(), added.maker())
                            .forEach(item -> world.arrests().suspect(item.id()));
            case WorldChange.Removed removed -> {
                if (removed.cascade().isEmpty()) {
                    world.remove(removed.item());
                } else {
                    world.removeCascade(removed.item());
                }
            }
            case WorldChange.Renamed renamed -> world.restoreName(renamed.item(), renamed.to());
            case WorldChange.Attached attached ->
                    world.attach(attached.item(), attached.to().parent(), attached.to().pose());
            case WorldChange.Detached detached -> world.detach(detached.item());
            case WorldChange.Edited edited -> edit(world, world.item(edited.item()), edited);
            case WorldChange.Pushed pushed -> {
                world.arrests().suspect(pushed.force().item());
                world.forces().add(pushed.force());
            }
            case WorldChange.ColumnEdited column -> write(world, column, noted.columnRows);
            case WorldChange.Restored restored ->
                    throw new IllegalArgumentException(
                            "the world went back to frame " + restored.frame());
        }
    }

    private static void edit(World world, Item item, WorldChange.Edited edited) {
        switch (edited.aspect()) {
            case SEMANTIC, ACCESS -> {}
            case PHYSICAL -> {
                world.arrests().suspect(item.id());
                editPhysical(item, edited);
            }
            case PHYSICS -> {
                world.arrests().suspect(item.id());
                if (edited.to() == null) {
                    item.physics().clear();
                } else if (edited.to() instanceof List<?> list
                        && !list.isEmpty()
                        && list.getFirst() instanceof ItemId) {
                    item.physics()
                            .setReferences(
                                    edited.property(),
                                    list.stream().map(ItemId.class::cast).toArray(ItemId[]::new));
                } else {
                    item.physics().set(edited.property(), numbers(edited.to()));
                }
            }
        }
    }

    private static void editPhysical(Item item, WorldChange.Edited edited) {
        Object to = edited.to();
        switch (edited.property()) {
            case "location" -> {
                double[] n = numbers(to);
                item.physical().setLocation(n[0], n[1], n[2]);
            }
            case "orientation" -> {
                double[] n = numbers(to);
                item.physical().setOrientation(n[0], n[1], n[2], n[3]);
            }
            case "shape" -> item.physical().setShape((Shape) to);
            case "material" -> item.physical().setMaterial(Optional.ofNullable((Material) to));
            case "colour" -> item.physical().setColour((Colour) to);
            case ConnectionLook.WIDTH -> item.physical().setWidth((Double) to);
            default ->
                    throw new IllegalArgumentException(
                            "the physical aspect has no " + edited.property());
        }
    }

    private static double[] numbers(@Nullable Object to) {
        if (to instanceof List<?> list) {
            return list.stream().mapToDouble(number -> ((Number) number).doubleValue()).toArray();
        }
        throw new IllegalArgumentException("found " + to + ", expected numbers");
    }

    private static void write(
            World world, WorldChange.ColumnEdited change, byte @Nullable [] rows) {
        Column column = world.table(change.kind()).column(change.property());
        if (rows == null || rows.length != column.segment().byteSize()) {
            throw new IllegalArgumentException(column + " has another number of rows");
        }
        MemorySegment.copy(rows, 0, column.segment(), ValueLayout.JAVA_BYTE, 0, rows.length);
        column.touch();
    }
}
