// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.world.Action;
import reve.core.world.Attachment;
import reve.core.world.Colour;
import reve.core.world.ColumnSnapshot;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Level;
import reve.core.world.Mesh;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.TableSnapshot;
import reve.core.world.Voice;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** The report of an item: its four aspects in one frame, with the unit of each number. */
final class ItemReport {

    /**
     * Names of the columns that belong to the physical aspect. The other columns of the item's
     * table belong to the physics aspect.
     */
    private static final Set<String> PHYSICAL =
            Set.of("position", "orientation", "size", "shape", "colour", "boundsMin", "boundsMax");

    private ItemReport() {}

    static Map<String, Object> of(WorldSnapshot snapshot, ItemSymbols item) {
        var content = new LinkedHashMap<String, Object>();
        content.put("name", item.name());
        content.put("kind", item.kind());
        TableSnapshot table = snapshot.table(item.kind());
        int row = row(table, item.id());
        content.put(
                "physical",
                item.kind().equals(WorldPrototype.BODY) && row >= 0
                        ? physical(snapshot, table, row, item)
                        : look(item));
        content.put("semantic", item.symbols());
        if (!item.levels().isEmpty()) {
            content.put("levels", item.levels().stream().map(Level::name).toList());
        }
        content.put("access", access(item));
        content.put(
                "physics",
                row >= 0 && row < table.physicsRowCount()
                        ? physics(snapshot, table, row)
                        : List.of());
        return content;
    }

    private static int row(TableSnapshot table, ItemId id) {
        ColumnSnapshot ids = table.ids();
        for (int row = 0; row < table.rowCount(); row++) {
            if (ids.getReference(row, 0) == id.value()) {
                return row;
            }
        }
        return -1;
    }

    private static List<Object> physical(
            WorldSnapshot snapshot, TableSnapshot table, int row, ItemSymbols item) {
        var all = new ArrayList<Object>();
        all.add(property("location", numbers(table.column("position"), row), "m", true));
        all.add(property("orientation", numbers(table.column("orientation"), row), "1", true));
        all.add(property("shape", shape(item.shape()), "", false));
        if (item.shape() != Shape.none()) {
            all.add(property("size", numbers(table.column("size"), row), "m", false));
        }
        all.add(
                property(
                        "colour",
                        new Colour(table.column("colour").getInt(row, 0)).toString(),
                        "",
                        true));
        Attachment attachment = item.attachment();
        if (attachment != null) {
            ItemSymbols parent = snapshot.symbols().get(attachment.parent());
            all.add(property("attached to", parent == null ? "?" : parent.name(), "", false));
        }
        return all;
    }

    /** Returns the appearance of a spring or a surface; empty for other kinds. */
    private static List<Object> look(ItemSymbols item) {
        var all = new ArrayList<Object>();
        ConnectionLook look = item.look();
        boolean isSpring = item.kind().equals(WorldPrototype.SPRING);
        look.colour()
                .or(() -> isSpring ? Optional.of(ConnectionLook.SPRING_COLOUR) : Optional.empty())
                .ifPresent(colour -> all.add(property("colour", colour.toString(), "", true)));
        if (isSpring) {
            all.add(property(ConnectionLook.WIDTH, look.width(), "m", true));
        }
        return all;
    }

    private static String shape(Shape shape) {
        return switch (shape) {
            case Shape.None none -> "none";
            case Shape.Sphere sphere -> "sphere";
            case Shape.Box box -> "box";
            case Shape.Plane plane -> "plane";
            case Shape.Capsule capsule -> "capsule";
            case Shape.Cylinder cylinder -> "cylinder";
            case Shape.Ellipsoid ellipsoid -> "ellipsoid";
            case Mesh mesh -> {
                String kind = mesh.relief().isPresent() ? "terrain" : "mesh";
                yield mesh.file().map(file -> kind + " " + file).orElse(kind);
            }
        };
    }

    private static List<Object> physics(WorldSnapshot snapshot, TableSnapshot table, int row) {
        var all = new ArrayList<Object>();
        for (ColumnSnapshot column : table.columns()) {
            if (table.kind().equals(WorldPrototype.BODY) && PHYSICAL.contains(column.name())) {
                continue;
            }
            PropertyDescriptor descriptor = column.descriptor();
            boolean refers = column.type() == ScalarType.REF;
            Map<String, Object> property =
                    property(
                            column.name(),
                            refers ? names(snapshot, column, row) : numbers(column, row),
                            descriptor.unit().symbol(),
                            !refers);
            if (!descriptor.doc().isEmpty()) {
                property.put("doc", descriptor.doc());
            }
            all.add(property);
        }
        return all;
    }

    private static Map<String, Object> property(
            String name, Object value, String unit, boolean editable) {
        var property = new LinkedHashMap<String, Object>();
        property.put("name", name);
        property.put("value", value);
        if (!unit.isEmpty()) {
            property.put("unit", unit);
        }
        property.put("editable", editable);
        return property;
    }

    private static Object numbers(ColumnSnapshot column, int row) {
        if (column.components() == 1) {
            return column.getDouble(row, 0);
        }
        var numbers = new ArrayList<Object>(column.components());
        for (int i = 0; i < column.components(); i++) {
            numbers.add(column.getDouble(row, i));
        }
        return numbers;
    }

    private static List<Object> names(WorldSnapshot snapshot, ColumnSnapshot column, int row) {
        var names = new ArrayList<Object>(column.components());
        for (int i = 0; i < column.components(); i++) {
            long id = column.getReference(row, i);
            ItemSymbols target = id > 0 ? snapshot.symbols().get(new ItemId(id)) : null;
            names.add(target == null ? "" : target.name());
        }
        return names;
    }

    private static Map<String, Object> access(ItemSymbols item) {
        var access = new LinkedHashMap<String, Object>();
        var actions = new ArrayList<Object>();
        for (Action action : item.actions()) {
            var fields = new LinkedHashMap<String, Object>();
            fields.put("name", action.name());
            fields.put("doc", action.doc());
            fields.put("needs", List.copyOf(action.needs()));
            fields.put(
                    "parameters", action.parameters().stream().map(ItemReport::parameter).toList());
            actions.add(fields);
        }
        access.put("actions", actions);
        access.put("capabilities", item.capabilities());
        access.put("sensors", item.sensors().stream().map(Sensor::name).toList());
        item.voice().ifPresent(voice -> access.put("voice", voice(voice)));
        return access;
    }

    /** Returns the distances of a voice [m]; omits a distance without a limit. */
    private static Map<String, Object> voice(Voice voice) {
        var fields = new LinkedHashMap<String, Object>();
        if (Double.isFinite(voice.range())) {
            fields.put("range", voice.range());
        }
        if (Double.isFinite(voice.fading())) {
            fields.put("fading", voice.fading());
        }
        return fields;
    }

    private static Map<String, Object> parameter(Parameter parameter) {
        var fields = new LinkedHashMap<String, Object>();
        fields.put("name", parameter.name());
        fields.put("doc", parameter.doc());
        fields.put("type", parameter.type().name().toLowerCase(Locale.ROOT));
        if (parameter.type() == ParameterType.NUMBER) {
            fields.put("components", parameter.components());
            fields.put("unit", parameter.unit().symbol());
            if (Double.isFinite(parameter.minimum())) {
                fields.put("min", parameter.minimum());
            }
            if (Double.isFinite(parameter.maximum())) {
                fields.put("max", parameter.maximum());
            }
        }
        return fields;
    }
}
