package reve.core.agent;

import java.io.ByteArrayOutputStream;
import java.io.StringWriter;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import reve.core.world.Action;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;
import reve.core.world.Relations;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;
import tools.jackson.core.JsonGenerator;
import tools.jackson.core.io.SerializedString;

/**
 * Writes what all agents perceive of a frame. What is symbolic is kept encoded for as long as it does not change.
 * One thread.
 */
final class PerceptionEncoder {

    private static final SerializedString NAME = new SerializedString("name");
    private static final SerializedString LOCATION = new SerializedString("location");
    private static final SerializedString SYMBOLS = new SerializedString("symbols");
    private static final SerializedString ACTIONS = new SerializedString("actions");
    private static final SerializedString NEEDS = new SerializedString("needs");
    private static final SerializedString CAPABILITIES = new SerializedString("capabilities");
    private static final List<String> RELATIONS = Relations.NAMES.stream().sorted().toList();
    private static final int COORDINATES = 3;

    private final ByteArrayOutputStream bytes = new ByteArrayOutputStream(8 * 1024);
    private @Nullable PMap<ItemId, ItemSymbols> encoded;
    private Map<ItemId, EncodedItem> items = new HashMap<>();
    private List<EncodedItem> inOrder = List.of();

    /** An item's symbolic part as JSON values. */
    private record EncodedItem(ItemSymbols source, SerializedString name, SerializedString symbols,
            SerializedString actions, Optional<SerializedString> needs, Optional<SerializedString> capabilities) {}

    /**
     * The frame's perception without the line's beginning, which differs between agents: everything after
     * {@code "id":…,}.
     *
     * @param relations whether symbols hold what is near, on, inside and touching, too
     * @return empty if the snapshot was lost meanwhile
     */
    Optional<byte[]> encode(WorldSnapshot snapshot, boolean relations) {
        encodeSymbols(snapshot.symbols());
        bytes.reset();
        try (JsonGenerator json = Json.MAPPER.createGenerator(bytes)) {
            json.writeStartObject();
            json.writeNumberProperty("frame", snapshot.frame());
            json.writeNumberProperty("time", snapshot.timeSeconds());
            json.writeArrayPropertyStart("items");
            TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
            var position = bodies.column("position");
            double[] location = new double[COORDINATES];
            for (EncodedItem item : inOrder) {
                int row = bodies.rowOf(item.source.id());
                for (int i = 0; row >= 0 && i < COORDINATES; i++) {
                    location[i] = position.getDouble(row, i);
                }
                write(json, item, row < 0 ? null : location,
                        relations ? withRelations(item, snapshot.relations()) : item.symbols);
            }
            json.writeEndArray();
            json.writeEndObject();
        } catch (RuntimeException e) {
            if (snapshot.lost()) {
                return Optional.empty(); // what we read was being overwritten, and cannot make sense
            }
            throw e;
        }
        bytes.write('\n');
        byte[] all = bytes.toByteArray();
        return snapshot.lost() ? Optional.empty() : Optional.of(Arrays.copyOfRange(all, 1, all.length));
    }

    /** The item's symbols and, for bodies with a shape, its relations. */
    private static SerializedString withRelations(EncodedItem item, Relations relations) {
        SerializedString more = value(json -> {
            json.writeStartObject();
            for (String relation : RELATIONS) {
                relations.of(item.source.id(), relation).ifPresent(names -> {
                    json.writeName(relation);
                    Json.writeValue(json, names);
                });
            }
            json.writeEndObject();
        });
        String symbols = item.symbols.getValue();
        return more.getValue().equals("{}") ? item.symbols : new SerializedString(
                symbols.substring(0, symbols.length() - 1) + "," + more.getValue().substring(1));
    }

    private static void write(JsonGenerator json, EncodedItem item, double @Nullable [] location,
            SerializedString symbols) {
        json.writeStartObject();
        json.writeName(NAME);
        json.writeRawValue(item.name);
        if (location != null) {
            json.writeName(LOCATION);
            json.writeArray(location, 0, COORDINATES);
        }
        json.writeName(SYMBOLS);
        json.writeRawValue(symbols);
        json.writeName(ACTIONS);
        json.writeRawValue(item.actions);
        item.needs.ifPresent(needs -> {
            json.writeName(NEEDS);
            json.writeRawValue(needs);
        });
        item.capabilities.ifPresent(capabilities -> {
            json.writeName(CAPABILITIES);
            json.writeRawValue(capabilities);
        });
        json.writeEndObject();
    }

    private void encodeSymbols(PMap<ItemId, ItemSymbols> symbols) {
        if (symbols == encoded) {
            return;
        }
        var known = new HashMap<ItemId, EncodedItem>();
        var order = new ArrayList<EncodedItem>(symbols.size());
        for (ItemSymbols item : symbols.values()) {
            if (!item.kind().equals(WorldPrototype.WORLD)) {
                EncodedItem before = items.get(item.id());
                EncodedItem now = before != null && before.source == item ? before : encode(item);
                known.put(item.id(), now);
                order.add(now);
            }
        }
        items = known;
        inOrder = order;
        encoded = symbols;
    }

    private static EncodedItem encode(ItemSymbols item) {
        return new EncodedItem(item, value(json -> json.writeString(item.name())),
                value(json -> writeSymbols(json, item)), value(json -> writeActions(json, item.actions())),
                needs(item.actions()), item.capabilities().isEmpty() ? Optional.empty()
                        : Optional.of(value(json -> Json.writeValue(json, item.capabilities()))));
    }

    /** The capabilities that actions need, by their names; empty if none needs any. */
    private static Optional<SerializedString> needs(List<Action> actions) {
        return actions.stream().allMatch(action -> action.needs().isEmpty()) ? Optional.empty()
                : Optional.of(value(json -> {
                    json.writeStartObject();
                    actions.stream().filter(action -> !action.needs().isEmpty()).forEach(action -> {
                        json.writeName(action.name());
                        Json.writeValue(json, action.needs());
                    });
                    json.writeEndObject();
                }));
    }

    private static void writeSymbols(JsonGenerator json, ItemSymbols item) {
        json.writeStartObject();
        item.symbols().forEach((symbol, value) -> {
            json.writeName(symbol);
            Json.writeValue(json, value);
        });
        json.writeEndObject();
    }

    private static void writeActions(JsonGenerator json, List<Action> actions) {
        json.writeStartObject();
        for (Action action : actions) {
            json.writeObjectPropertyStart(action.name());
            for (Parameter parameter : action.parameters()) {
                json.writeObjectPropertyStart(parameter.name());
                json.writeStringProperty("type", switch (parameter.type()) {
                    case NUMBER -> "number";
                    case TEXT -> "text";
                    case TRUTH -> "truth";
                    case ITEM -> "item";
                });
                if (parameter.type() == ParameterType.NUMBER) {
                    json.writeNumberProperty("components", parameter.components());
                    json.writeStringProperty("unit", parameter.unit().symbol());
                    writeBound(json, "min", parameter.minimum());
                    writeBound(json, "max", parameter.maximum());
                }
                json.writeEndObject();
            }
            json.writeEndObject();
        }
        json.writeEndObject();
    }

    private static void writeBound(JsonGenerator json, String name, double bound) {
        if (Double.isFinite(bound)) {
            json.writeNumberProperty(name, bound);
        }
    }

    private interface ValueWriter {
        void writeTo(JsonGenerator json);
    }

    private static SerializedString value(ValueWriter writer) {
        var out = new StringWriter();
        try (JsonGenerator json = Json.MAPPER.createGenerator(out)) {
            writer.writeTo(json);
        }
        return new SerializedString(out.toString());
    }
}
