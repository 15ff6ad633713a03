package reve.core.store;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.IntStream;
import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

/**
 * Maps, lists, texts and numbers as JSON and back. Doubles come back to the bit. What does not have
 * the form that was written is a {@link CorruptException}.
 */
public final class Trees {

    private static final JsonMapper MAPPER = new JsonMapper();

    private Trees() {}

    /** @param tree of Map, List, String, Number and Boolean */
    public static byte[] write(Object tree) {
        return MAPPER.writeValueAsBytes(tree);
    }

    /** The tree that was written. */
    public static JsonNode read(byte[] json) {
        try {
            return MAPPER.readTree(json);
        } catch (JacksonException e) {
            throw new CorruptException("no JSON: " + e.getOriginalMessage(), e);
        }
    }

    /** A field that has to be there. */
    public static JsonNode field(JsonNode object, String name) {
        JsonNode field = object.get(name);
        if (field == null) {
            throw new CorruptException("the field " + name + " is missing");
        }
        return field;
    }

    /** A text that has to be there. */
    public static String text(JsonNode object, String name) {
        return field(object, name).asString();
    }

    /** An integer that has to be there. */
    public static long integer(JsonNode object, String name) {
        return integer(field(object, name));
    }

    static long integer(JsonNode node) {
        if (!node.isIntegralNumber()) {
            throw new CorruptException("found " + node + ", expected an integer");
        }
        return node.asLong();
    }

    static List<JsonNode> list(JsonNode object, String name) {
        JsonNode array = field(object, name);
        if (!array.isArray()) {
            throw new CorruptException("the field " + name + " is no list");
        }
        List<JsonNode> elements = new ArrayList<>(array.size());
        array.forEach(elements::add);
        return elements;
    }

    /** Texts, truths, Doubles and lists of these by name, in their order. */
    static Map<String, Object> values(JsonNode object) {
        Map<String, Object> values = new LinkedHashMap<>();
        object.properties().forEach(field -> values.put(field.getKey(), value(field.getValue())));
        return values;
    }

    static Object value(JsonNode node) {
        if (node.isArray()) {
            return IntStream.range(0, node.size()).mapToObj(i -> value(node.get(i))).toList();
        }
        return node.isBoolean() ? node.asBoolean()
                : node.isNumber() ? (Object) node.asDouble() : node.asString();
    }

    static double[] numbers(JsonNode array) {
        return IntStream.range(0, array.size()).mapToDouble(i -> array.get(i).asDouble()).toArray();
    }
}
