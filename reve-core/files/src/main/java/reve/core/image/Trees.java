// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import tools.jackson.core.JacksonException;
import tools.jackson.core.exc.StreamConstraintsException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.IntStream;

/**
 * The codec of trees (maps, lists, texts and numbers) as JSON. Doubles are restored to the bit. The
 * methods throw a {@link CorruptException} if the input does not have the required form.
 */
public final class Trees {

    private static final JsonMapper MAPPER = new JsonMapper();

    /** Maximum length of a quoted value in a message [characters]. */
    private static final int SHOWN = 80;

    private Trees() {}

    /**
     * Encodes a tree.
     *
     * @param tree a Map or List whose values are Strings, Numbers, Booleans, Maps and Lists
     */
    public static byte[] write(Object tree) {
        return MAPPER.writeValueAsBytes(tree);
    }

    /** Returns the tree that {@link #write} has encoded. */
    public static JsonNode read(byte[] json) {
        try {
            return MAPPER.readTree(json);
        } catch (StreamConstraintsException e) {
            throw new CorruptException(
                    "JSON is nested too deep, or a text or number of it is too " + "long", e);
        } catch (JacksonException e) {
            throw new CorruptException("no JSON: " + e.getOriginalMessage(), e);
        }
    }

    /** Returns a required field. */
    public static JsonNode field(JsonNode object, String name) {
        JsonNode field = object.get(name);
        if (field == null) {
            throw new CorruptException("the field " + name + " is missing");
        }
        return field;
    }

    /** Returns a required text. */
    public static String text(JsonNode object, String name) {
        return text("the field " + name, field(object, name));
    }

    /** Returns a required integer. */
    public static long integer(JsonNode object, String name) {
        return integer("the field " + name, field(object, name));
    }

    static long integer(JsonNode node) {
        return integer("a value", node);
    }

    /** Returns a required integer from 0 to {@code most}. */
    static int count(JsonNode object, String name, int most) {
        long count = integer(object, name);
        if (count < 0 || count > most) {
            throw new CorruptException(
                    "the field " + name + ": found " + count + ", expected 0 to " + most);
        }
        return (int) count;
    }

    private static long integer(String what, JsonNode node) {
        if (!node.isIntegralNumber() || !node.canConvertToLong()) {
            throw other(what, node, "an integer of 64 bits");
        }
        return node.asLong();
    }

    /**
     * Returns a value that must be a text.
     *
     * @param what name of the value in messages
     */
    static String text(String what, JsonNode node) {
        if (!node.isString()) {
            throw other(what, node, "a text");
        }
        return node.asString();
    }

    /**
     * Returns a value that must be a number.
     *
     * @param what name of the value in messages
     */
    public static double number(String what, JsonNode node) {
        if (!node.isNumber()) {
            throw other(what, node, "a number");
        }
        return node.asDouble();
    }

    private static CorruptException other(String what, JsonNode found, String expected) {
        String shown =
                switch (found.getNodeType()) {
                    case ARRAY -> "a list";
                    case OBJECT -> "an object";
                    case MISSING -> "nothing";
                    default -> found.toString();
                };
        return new CorruptException(
                what
                        + ": found "
                        + (shown.length() > SHOWN ? shown.substring(0, SHOWN) + "..." : shown)
                        + ", expected "
                        + expected);
    }

    /** Returns the elements of a list. Returns an empty list if the field is missing. */
    public static List<JsonNode> listIfAny(JsonNode object, String name) {
        return object.has(name) ? list(object, name) : List.of();
    }

    static List<JsonNode> list(JsonNode object, String name) {
        JsonNode array = field(object, name);
        if (!array.isArray()) {
            throw other("the field " + name, array, "a list");
        }
        List<JsonNode> elements = new ArrayList<>(array.size());
        array.forEach(elements::add);
        return elements;
    }

    /**
     * Returns the fields of an object by name, in order, as String, Boolean, Double or a List of
     * these.
     */
    static Map<String, Object> values(JsonNode object) {
        Map<String, Object> values = new LinkedHashMap<>();
        object.properties().forEach(field -> values.put(field.getKey(), value(field.getValue())));
        return values;
    }

    static Object value(JsonNode node) {
        if (node.isArray()) {
            return IntStream.range(0, node.size()).mapToObj(i -> value(node.get(i))).toList();
        }
        return node.isBoolean()
                ? node.asBoolean()
                : node.isNumber() ? (Object) node.asDouble() : text("a value", node);
    }

    static double[] numbers(JsonNode array) {
        if (!array.isArray()) {
            throw other("numbers", array, "a list");
        }
        return IntStream.range(0, array.size())
                .mapToDouble(i -> number("a number", array.get(i)))
                .toArray();
    }
}
