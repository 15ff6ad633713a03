// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Column;
import reve.core.world.ColumnArena;
import reve.core.world.Item;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PropertyDescriptor;
import reve.pe.ScalarType;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/** The columns of a world that are bound to an engine. For the world's thread only. */
final class BoundWorld {
    private final World world;
    private final PhysicsEngine engine;
    private final PhysicalPropertyProvider provider;

    /**
     * The bound properties. Columns come first, because they depend on no other property, and the
     * engine must release their old memory before it reads the other properties.
     */
    private final BoundProperty[] properties;

    private final List<BoundRows> rows;

    /** The properties that describe meshes; the engine has them only if an item has a mesh. */
    private final Set<BoundProperty> ofMeshes = new LinkedHashSet<>();

    private final BoundMeshes meshes;

    /** Properties that the engine receives only while a law uses them. */
    private final Set<BoundProperty> onDemand = new LinkedHashSet<>();

    private Set<String> used = Set.of();
    private boolean areMeshesUsed;

    /**
     * True after a change of the properties that the laws use, until the engine has received these
     * properties.
     */
    private boolean isLendingMore;

    private long boundLayout = -1;

    BoundWorld(World world, PhysicsEngine engine, ColumnArena arena) {
        this.world = world;
        this.engine = engine;
        this.provider = engine.propertyProvider();
        meshes = new BoundMeshes(world, world.table(WorldPrototype.BODY), arena);
        List<BoundProperty> inPlace = new ArrayList<>();
        List<BoundProperty> references = new ArrayList<>();
        for (PropertyDescriptor property : engine.prototype().properties()) {
            if (property.type() == ScalarType.FIELD) {
                continue; // the world has no fields; law libraries provide them
            }
            Table table = world.table(PropertyNames.table(property.kind()));
            boolean scenery = property.kind().equals(PropertyNames.SCENERY);
            if (PropertyNames.isCarrier(property)) {
                inPlace.add(new BoundCarriers(property.name(), world, table, scenery, arena));
                onDemand.add(inPlace.getLast());
                continue;
            }
            if (PropertyNames.isOfMeshes(property)) {
                inPlace.add(meshes.property(property.name(), property.kind(), scenery));
                onDemand.add(inPlace.getLast());
                ofMeshes.add(inPlace.getLast());
                continue;
            }
            List<Column> columns =
                    PropertyNames.columns(property.kind(), property.name()).stream()
                            .map(table::column)
                            .toList();
            if (property.refersTo() == null) {
                inPlace.add(new BoundColumn(property.name(), table, scenery, columns.getFirst()));
                if (PropertyNames.isOnDemand(property)) {
                    onDemand.add(inPlace.getLast());
                }
            } else {
                references.add(
                        new BoundReferences(
                                property.name(),
                                world,
                                table,
                                world.table(property.refersTo()),
                                columns,
                                arena));
            }
        }
        inPlace.addAll(references);
        properties = inPlace.toArray(BoundProperty[]::new);
        rows = inPlace.stream().map(BoundProperty::table).distinct().map(BoundRows::new).toList();
    }

    /**
     * Passes changes of the world to the engine. The call takes almost no time if nothing has
     * changed. All columns of a kind must have the same number of rows in the engine. Therefore the
     * bound columns get their new rows before the engine receives further columns.
     *
     * @throws IllegalStateException naming item and property if a reference is invalid
     */
    void update() {
        boolean moved = world.layoutVersion() != boundLayout;
        if (moved) {
            rows.forEach(table -> table.follow(engine));
        }
        boolean remeshed = followMeshes(moved);
        for (BoundProperty property : properties) {
            if (!property.isBound()) {
                continue;
            }
            if (isRebound(property, moved, remeshed)) {
                property.bind(provider);
            } else {
                property.touchIfEdited(provider);
            }
        }
        if (moved || remeshed || isLendingMore) {
            for (BoundProperty property : properties) {
                if (!property.isBound() && isLent(property)) {
                    property.bind(provider);
                }
            }
        }
        isLendingMore = false;
        boundLayout = world.layoutVersion();
    }

    /**
     * Reads the meshes of the items, if a law uses them and they have changed. Removes the
     * properties of meshes from the engine if no item has a mesh.
     */
    private boolean followMeshes(boolean moved) {
        if (!areMeshesUsed) {
            return false;
        }
        boolean changed = meshes.follow(moved || isLendingMore);
        if (changed && meshes.isEmpty()) {
            ofMeshes.forEach(property -> property.unbind(provider));
        }
        return changed;
    }

    private boolean isRebound(BoundProperty property, boolean moved, boolean remeshed) {
        return property instanceof BoundMeshes.Data
                ? remeshed
                : moved || remeshed && ofMeshes.contains(property);
    }

    /**
     * Sets the names of the properties that the loaded laws use; the change takes effect with
     * {@link #update}. The engine receives the shapes and the scenery only while a law uses them.
     * These properties therefore do not change the hashes of worlds in which no law uses them.
     */
    void setUsed(Set<String> names) {
        used = names;
        areMeshesUsed = ofMeshes.stream().anyMatch(property -> used.contains(property.name()));
        for (BoundProperty property : onDemand) {
            if (!isLent(property)) {
                property.unbind(provider);
            }
        }
        isLendingMore = true;
    }

    private boolean isLent(BoundProperty property) {
        return !onDemand.contains(property)
                || used.contains(property.name())
                        && !(ofMeshes.contains(property) && meshes.isEmpty());
    }

    /** Returns the layout version of the world at the last update; -1 before the first update. */
    long boundLayout() {
        return boundLayout;
    }

    /** Returns the in-place columns of these properties, in a fixed order. */
    List<BoundColumn> columns(Set<String> names) {
        return Arrays.stream(properties)
                .filter(property -> names.contains(property.name()))
                .filter(BoundColumn.class::isInstance)
                .map(BoundColumn.class::cast)
                .toList();
    }

    /** Returns the item in one of the engine's rows of a kind. */
    Optional<Item> item(String kind, long row) {
        boolean scenery = kind.equals(PropertyNames.SCENERY);
        return Arrays.stream(properties)
                .map(BoundProperty::table)
                .filter(table -> table.kind().equals(PropertyNames.table(kind)))
                .findFirst()
                .filter(table -> row < (scenery ? table.rowCount() : table.physicsRowCount()))
                .map(table -> world.item(table.idAt((int) row)));
    }
}
