// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import reve.core.world.WorldChange.Added;
import reve.core.world.WorldChange.Attached;
import reve.core.world.WorldChange.ColumnEdited;
import reve.core.world.WorldChange.Detached;
import reve.core.world.WorldChange.Edited;
import reve.core.world.WorldChange.Pushed;
import reve.core.world.WorldChange.Removed;
import reve.core.world.WorldChange.Renamed;
import reve.core.world.WorldChange.Restored;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;

/**
 * A copy of a world by a listener that receives only changes. It has plain values and no columns.
 * It reads a column only after direct writes to this column, as their change prescribes.
 */
final class WorldMirror {

    /**
     * An item. If it has a parent, its pose is in the frame of the parent, and otherwise in the
     * frame of the world.
     */
    static final class Mirrored {
        final String kind;
        String name;
        @Nullable ItemId parent;
        Pose pose;
        Shape shape;
        Optional<Material> material;
        Colour colour;
        final Map<String, Object> symbols;
        final Map<String, Action> actions = new LinkedHashMap<>();

        /** Numbers as a {@code List<Double>}, references as a {@code List<ItemId>}. */
        final Map<String, Object> physics = new TreeMap<>();

        private Mirrored(ItemDefinition definition) {
            kind = definition.kind();
            name = definition.name();
            pose = Pose.of(definition.location(), definition.orientation());
            shape = definition.shape();
            material = definition.material();
            colour = definition.colour();
            symbols = new TreeMap<>(definition.symbols());
            definition.actions().forEach(action -> actions.put(action.name(), action));
        }
    }

    private final WorldPrototype prototype;
    private final Map<ItemId, Mirrored> items = new TreeMap<>(Comparator.comparing(ItemId::value));

    WorldMirror(WorldPrototype prototype) {
        this.prototype = prototype;
    }

    Map<ItemId, Mirrored> items() {
        return items;
    }

    /**
     * @param world for {@link ColumnEdited}, whose numbers are in the column
     */
    void follow(List<WorldChange> changes, World world) {
        changes.forEach(this::follow);
        for (WorldChange change : changes) {
            if (change instanceof ColumnEdited column) {
                read(world.table(column.kind()), column.property());
            }
        }
    }

    private void follow(WorldChange change) {
        switch (change) {
            case Added added -> add(added);
            case Removed removed -> {
                removed.cascade().forEach(items::remove);
                items.remove(removed.item());
            }
            case Renamed renamed -> item(renamed.item()).name = renamed.to();
            case Attached attached -> {
                item(attached.item()).parent = attached.to().parent();
                item(attached.item()).pose = attached.to().pose();
            }
            case Detached detached -> {
                Pose place = place(item(detached.item()));
                item(detached.item()).parent = null;
                item(detached.item()).pose = place;
            }
            case Edited edited -> edit(item(edited.item()), edited);
            case ColumnEdited _ -> {} // the sum of all changes is in the column
            case Pushed pushed -> throw new AssertionError("nobody pushes here: " + pushed);
            case Restored restored -> throw new AssertionError("nobody goes back: " + restored);
        }
    }

    /** Returns the pose of an item in the frame of the world. */
    Pose place(Mirrored item) {
        return item.parent == null ? item.pose : item.pose.within(place(item(item.parent)));
    }

    private Mirrored item(ItemId id) {
        return items.get(id);
    }

    private void add(Added added) {
        Map<String, ItemId> byName = new HashMap<>();
        items.forEach((id, item) -> byName.put(item.name, id));
        List<Mirrored> news = new ArrayList<>();
        for (ItemDefinition definition : added.definitions()) {
            var id = new ItemId(added.first().value() + news.size());
            news.add(new Mirrored(definition));
            byName.put(definition.name(), id);
            items.put(id, news.getLast());
        }
        for (int i = 0; i < news.size(); i++) {
            Mirrored item = news.get(i);
            ItemDefinition definition = added.definitions().get(i);
            definition.parent().ifPresent(name -> item.parent = byName.get(name));
            if (definition.hasPhysics()) {
                zero(item);
            }
            definition
                    .physicsProperties()
                    .forEach(
                            property ->
                                    item.physics.put(
                                            property,
                                            kept(
                                                    item,
                                                    property,
                                                    definition.physics(property).orElseThrow())));
            definition
                    .references()
                    .forEach(
                            (property, names) ->
                                    item.physics.put(
                                            property, names.stream().map(byName::get).toList()));
        }
    }

    /** Returns the numbers of a definition in the precision of a column of that type. */
    private List<Double> kept(Mirrored item, String property, double[] said) {
        boolean single = prototype.find(item.kind, property).orElseThrow().type() == ScalarType.F32;
        return Arrays.stream(said)
                .mapToObj(number -> single ? (double) (float) number : number)
                .toList();
    }

    /** Returns the values of an item of its kind when it enters physics. */
    private void zero(Mirrored item) {
        for (PropertyDescriptor property : prototype.properties()) {
            if (property.kind().equals(item.kind)) {
                item.physics.put(property.name(), list(new double[property.components()]));
            }
        }
    }

    private void edit(Mirrored item, Edited edited) {
        String property = edited.property();
        switch (edited.aspect()) {
            case PHYSICAL -> editPhysical(item, property, edited.to());
            case SEMANTIC -> put(item.symbols, property, edited.to());
            case ACCESS -> put(item.actions, property, (Action) edited.to());
            case PHYSICS -> {
                if (edited.from() == null) {
                    zero(item);
                }
                put(item.physics, property, edited.to());
            }
        }
    }

    private void editPhysical(Mirrored item, String property, @Nullable Object to) {
        switch (property) {
            case "location" -> put(item, Pose.of(numbers(to), place(item).orientation()));
            case "orientation" -> put(item, Pose.of(place(item).location(), numbers(to)));
            case "shape" -> item.shape = (Shape) to;
            case "material" -> item.material = Optional.ofNullable((Material) to);
            case "colour" -> item.colour = (Colour) to;
            default -> throw new AssertionError("unknown part " + property);
        }
    }

    private void put(Mirrored item, Pose place) {
        item.pose = item.parent == null ? place : place.relativeTo(place(item(item.parent)));
    }

    private void read(Table table, String property) {
        Column column = table.column(property);
        for (int row = 0; row < table.physicsRowCount(); row++) {
            double[] values = new double[column.components()];
            for (int i = 0; i < values.length; i++) {
                values[i] = column.getDouble(row, i);
            }
            item(table.idAt(row)).physics.put(property, list(values));
        }
    }

    private static <T> void put(Map<String, T> map, String key, @Nullable T value) {
        if (value == null) {
            map.remove(key);
        } else {
            map.put(key, value);
        }
    }

    private static List<Double> list(double[] values) {
        return Arrays.stream(values).boxed().toList();
    }

    private static double[] numbers(@Nullable Object list) {
        return ((List<?>) list).stream().mapToDouble(number -> (Double) number).toArray();
    }
}
