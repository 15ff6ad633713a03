// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Column;
import reve.core.world.ColumnArena;
import reve.core.world.Item;
import reve.core.world.Table;
import reve.core.world.World;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PropertyDescriptor;
import reve.pe.ScalarType;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/** A world's columns in the hands of an engine. World's thread only. */
final class LentWorld {
    private final World world;
    private final PhysicsEngine engine;
    private final PhysicalPropertyProvider provider;

    /** Columns first: they need no other to be right, and the engine must let go of old memory. */
    private final LentProperty[] properties;

    private final List<LentRows> rows;
    private long lentLayout = -1;

    LentWorld(World world, PhysicsEngine engine, ColumnArena arena) {
        this.world = world;
        this.engine = engine;
        this.provider = engine.propertyProvider();
        List<LentProperty> inPlace = new ArrayList<>();
        List<LentProperty> references = new ArrayList<>();
        for (PropertyDescriptor property : engine.prototype().properties()) {
            if (property.type() == ScalarType.FIELD) {
                continue; // the world holds no functions; law libraries bring them
            }
            Table table = world.table(property.kind());
            List<Column> columns =
                    PropertyNames.columns(property.kind(), property.name()).stream()
                            .map(table::column)
                            .toList();
            if (property.refersTo() == null) {
                inPlace.add(new LentColumn(property.name(), table, columns.getFirst()));
            } else {
                references.add(
                        new LentReferences(
                                property.name(),
                                world,
                                table,
                                world.table(property.refersTo()),
                                columns,
                                arena));
            }
        }
        inPlace.addAll(references);
        properties = inPlace.toArray(LentProperty[]::new);
        rows = inPlace.stream().map(LentProperty::table).distinct().map(LentRows::new).toList();
    }

    /**
     * Brings the engine up to date with the world; nearly free if nothing changed.
     *
     * @throws IllegalStateException naming item and property if a reference leads nowhere
     */
    void update() {
        if (world.layoutVersion() != lentLayout) {
            rows.forEach(table -> table.follow(engine));
            for (LentProperty property : properties) {
                property.lend(provider);
            }
            lentLayout = world.layoutVersion();
        } else {
            for (LentProperty property : properties) {
                property.touchIfEdited(provider);
            }
        }
    }

    /** The world's layout that the engine was told last; -1 before the first update. */
    long lentLayout() {
        return lentLayout;
    }

    /** The in-place columns of these properties, in a fixed order. */
    List<LentColumn> columns(Set<String> names) {
        return Arrays.stream(properties)
                .filter(property -> names.contains(property.name()))
                .filter(LentColumn.class::isInstance)
                .map(LentColumn.class::cast)
                .toList();
    }

    /** The item in one of the engine's rows of a kind. */
    Optional<Item> item(String kind, long row) {
        return Arrays.stream(properties)
                .map(LentProperty::table)
                .filter(table -> table.kind().equals(kind))
                .findFirst()
                .filter(table -> row < table.physicsRowCount())
                .map(table -> world.item(table.idAt((int) row)));
    }
}
