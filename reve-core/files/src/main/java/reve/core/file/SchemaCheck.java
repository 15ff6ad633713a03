// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import com.networknt.schema.Error;
import com.networknt.schema.Schema;
import com.networknt.schema.SchemaLocation;
import com.networknt.schema.SchemaRegistry;
import com.networknt.schema.SpecificationVersion;
import com.networknt.schema.path.NodePath;

import tools.jackson.core.JsonPointer;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.JsonNodeFactory;
import tools.jackson.databind.node.ObjectNode;

import java.io.IOException;
import java.io.InputStream;
import java.io.UncheckedIOException;
import java.math.BigDecimal;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Collection;
import java.util.Comparator;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/**
 * Check of a world file against the JSON schema of world files. It translates the errors of the
 * schema library into messages with the position in the file.
 */
final class SchemaCheck {
    private static final Source WORLD =
            new Source("/reve-world.schema.json", "urn:reve:world-file:1");
    private static final Schema FILE = WORLD.schema("");
    private static final Schema PART = WORLD.schema("#/$defs/part");
    private static final Schema ITEM = WORLD.schema("#/$defs/item");

    /**
     * Maximum number of elements of a list that are checked. It exceeds by one the maximum number
     * that the schema permits in lists with described elements.
     */
    private static final int MAX_ELEMENTS = 10_001;

    private static final Map<String, String> TYPES =
            Map.of(
                    "object",
                    "a mapping",
                    "array",
                    "a list",
                    "string",
                    "a text",
                    "number",
                    "a number",
                    "integer",
                    "a whole number",
                    "boolean",
                    "true or false");

    private static final Pattern DIGITS = Pattern.compile("\\d+( .*)?");

    private final Problems problems;
    private final JsonNode tree;

    /** True if a list or a mapping in the file is longer than permitted. */
    private boolean tooLong;

    private SchemaCheck(Problems problems) {
        this(problems, WORLD.tree);
    }

    private SchemaCheck(Problems problems, JsonNode tree) {
        this.problems = problems;
        this.tree = tree;
    }

    /** A schema file with its id. */
    private static final class Source {
        private final String id;
        private final JsonNode tree;
        private final SchemaRegistry registry;

        Source(String resource, String id) {
            String text = resource(resource);
            this.id = id;
            this.tree = JsonMapper.shared().readTree(text);
            this.registry =
                    SchemaRegistry.withDefaultDialect(
                            SpecificationVersion.DRAFT_2020_12,
                            builder -> builder.schemas(Map.of(id, text)));
        }

        Schema schema(String fragment) {
            return registry.getSchema(SchemaLocation.of(id + fragment));
        }
    }

    /** The schema of experiments. It is read when the first experiment is checked. */
    private static final class OfExperiments {
        private static final Source SOURCE =
                new Source("/reve-experiment.schema.json", "urn:reve:experiment:1");
        private static final Schema FILE = SOURCE.schema("");
    }

    /** Records all violations of the schema in a world file as problems. */
    static void check(Node root, Problems problems) throws WorldFileException {
        new SchemaCheck(problems).check(root, FILE);
    }

    /** Checks an included file, like {@link #check}. */
    static void checkPart(Node root, Problems problems) throws WorldFileException {
        new SchemaCheck(problems).check(root, PART);
    }

    /** Checks an experiment, like {@link #check}. */
    static void checkExperiment(Node root, Problems problems) throws WorldFileException {
        var check = new SchemaCheck(problems, OfExperiments.SOURCE.tree);
        check.report(OfExperiments.FILE.validate(toJson(root, Optional.empty())), root);
        check.endIfTooLong();
    }

    /** Checks a single item, like {@link #check}. */
    static void checkItem(Node item, Problems problems) throws WorldFileException {
        var check = new SchemaCheck(problems);
        check.report(ITEM.validate(toJson(item, Optional.empty())), item);
        check.endIfTooLong();
    }

    /**
     * Checks a file. The items are checked one by one, so that the check of many items ends when
     * the report is full.
     */
    private void check(Node root, Schema schema) throws WorldFileException {
        ObjectNode withoutItems = (ObjectNode) toJson(root, root.get("items").filter(Node::isList));
        report(schema.validate(withoutItems), root);
        for (Node item :
                root.get("items").filter(Node::isList).map(Node::children).orElse(List.of())) {
            if (tooLong || problems.full()) {
                break;
            }
            report(ITEM.validate(toJson(item, Optional.empty())), item);
        }
        endIfTooLong();
    }

    /**
     * Throws an exception if a list or mapping is too long. After this check, the readers can rely
     * on the limits.
     */
    private void endIfTooLong() throws WorldFileException {
        if (tooLong) {
            problems.throwIfAny();
        }
        problems.throwIfFull();
    }

    private void report(List<Error> errors, Node base) {
        List<Error> unknownFirst =
                errors.stream()
                        .sorted(
                                Comparator.comparing(
                                        error ->
                                                !error.getKeyword().equals("additionalProperties")))
                        .toList();
        for (Error error : unknownFirst) {
            if (problems.full()) {
                return;
            }
            Node node = resolve(base, error.getInstanceLocation());
            switch (error.getKeyword()) {
                case "type" -> {
                    if (!tellsOfDecimalComma(base, error, node)) {
                        problems.add(node, subject(node) + message(error, node));
                    }
                }
                case "additionalProperties" -> {
                    Node extra = node.get(error.getProperty()).orElse(node);
                    if (tellsOfDecimalComma(base, error, extra)) {
                        break;
                    }
                    problems.addUnknownKey(
                            node,
                            extra,
                            "unknown key `"
                                    + Node.shorten(extra.key())
                                    + "`"
                                    + hintForUnknownKey(error));
                }
                case "propertyNames" -> {
                    Node named = node.get(error.getProperty()).orElse(node);
                    problems.addAtKey(
                            named,
                            "`"
                                    + Node.shorten(named.key())
                                    + "` is not a name; expected "
                                    + description(error.getSchemaNode()));
                }
                case "required" -> {
                    if (!problems.isMisspelt(node)) {
                        problems.add(node, subject(node) + message(error, node));
                    }
                }
                case "maxItems", "maxProperties" -> {
                    tooLong = true;
                    problems.add(node, subject(node) + message(error, node));
                }
                default -> problems.add(node, subject(node) + message(error, node));
            }
        }
    }

    /**
     * Records a problem and returns true if the error is a decimal comma. YAML reads {@code mass:
     * 0,5} in braces as a mass of 0 and a key 5 without a value.
     */
    private boolean tellsOfDecimalComma(Node base, Error error, Node node) {
        boolean comma =
                node.isNothing() && DIGITS.matcher(node.key()).matches() && !node.isElement();
        if (comma) {
            problems.addUnknownKey(
                    mapping(base, error, node),
                    node,
                    "`"
                            + Node.shorten(node.key())
                            + "` stands for itself; if it is part of "
                            + "a number, a decimal point is written `.`, as in `0."
                            + Node.shorten(node.key().split(" ")[0])
                            + "`");
        }
        return comma;
    }

    /**
     * Returns the mapping that contains the node. The library reports this mapping instead of the
     * node if the key is unknown.
     */
    private static Node mapping(Node base, Error error, Node node) {
        Node reported = resolve(base, error.getInstanceLocation());
        return reported == node ? resolve(base, error.getInstanceLocation().getParent()) : reported;
    }

    private static String subject(Node node) {
        return node.label().isEmpty() ? "" : node.label() + ": ";
    }

    private String message(Error error, Node node) {
        JsonNode rule = error.getSchemaNode();
        return switch (error.getKeyword()) {
            case "required" -> "`" + error.getProperty() + "` is missing";
            case "type" ->
                    "found "
                            + node.describe()
                            + ", expected "
                            + types(rule)
                            + hintForType(rule, node);
            case "const" ->
                    "found "
                            + node.describe()
                            + ", expected "
                            + rule
                            + (rule.isNumber() ? ", the format version that is read here" : "");
            case "enum" ->
                    "found "
                            + node.describe()
                            + ", expected one of `"
                            + String.join("`, `", strings(rule))
                            + "`"
                            + node.text()
                                    .map(text -> problems.suggestion(text, strings(rule)))
                                    .orElse("");
            case "pattern" ->
                    "found "
                            + node.describe()
                            + ", expected "
                            + surrounding(error).path("description").asString();
            case "minimum" -> "found " + node.describe() + ", expected at least " + rule;
            case "maximum" -> "found " + node.describe() + ", expected at most " + rule;
            case "maxLength" ->
                    "found a text of "
                            + node.text().orElse("").length()
                            + " characters, expected at most "
                            + rule;
            case "minItems", "minProperties" ->
                    "found " + node.describe() + ", expected at least " + rule + " in it";
            case "maxItems", "maxProperties" ->
                    "found " + node.describe() + ", expected at most " + rule + " in it";
            case "uniqueItems" -> "found the same twice, expected each once";
            case "dependentRequired" -> "`body` is missing, which `places` are for";
            default -> error.getMessage();
        };
    }

    private static String types(JsonNode rule) {
        List<String> names = strings(rule).stream().map(TYPES::get).toList();
        return names.size() == 1
                ? names.getFirst()
                : String.join(", ", names.subList(0, names.size() - 1)) + " or " + names.getLast();
    }

    private static String hintForType(JsonNode rule, Node node) {
        if (!strings(rule).contains("string")) {
            return "";
        }
        if (node.isNothing() && node.key().equals("colour")) {
            return "; a # begins a comment, so put the colour in quotes";
        }
        boolean textOnly = strings(rule).size() == 1;
        return textOnly && node.scalar().isPresent() ? "; put it in quotes" : "";
    }

    private String hintForUnknownKey(Error error) {
        List<String> known = new ArrayList<>(surrounding(error).path("properties").propertyNames());
        String suggestion = problems.suggestion(error.getProperty(), known);
        return suggestion.isEmpty() ? "; known here: " + String.join(", ", known) : suggestion;
    }

    /** Returns the part of the schema that contains the violated rule. */
    private JsonNode surrounding(Error error) {
        String rule = error.getSchemaLocation().getFragment().toString();
        return tree.at(JsonPointer.compile(rule.substring(0, rule.lastIndexOf('/'))));
    }

    /**
     * Returns the description of a rule. Returns the description of the referenced rule if the rule
     * is a reference.
     */
    private String description(JsonNode rule) {
        JsonNode reference = rule.path("$ref");
        return (reference.isMissingNode()
                        ? rule
                        : tree.at(JsonPointer.compile(reference.asString().substring(1))))
                .path("description")
                .asString();
    }

    private static List<String> strings(JsonNode rule) {
        Collection<JsonNode> values = rule.isArray() ? rule.values() : List.of(rule);
        return values.stream().map(JsonNode::asString).collect(Collectors.toList());
    }

    private static Node resolve(Node base, NodePath path) {
        Node node = base;
        for (int i = 0; i < path.getNameCount(); i++) {
            Node current = node;
            node =
                    (path.getElement(i) instanceof Integer index
                                    ? current.get(index)
                                    : current.get(path.getName(i)))
                            .orElseThrow();
        }
        return node;
    }

    /**
     * Converts a node into the JSON tree of the schema library. Copies only the first elements of
     * long lists.
     *
     * @param emptied list that becomes an empty list
     */
    private static JsonNode toJson(Node node, Optional<Node> emptied) {
        JsonNodeFactory json = JsonNodeFactory.instance;
        if (node.isMapping()) {
            ObjectNode object = json.objectNode();
            node.children().forEach(child -> object.set(child.key(), toJson(child, emptied)));
            return object;
        }
        if (node.isList()) {
            ArrayNode array = json.arrayNode();
            if (emptied.isEmpty() || emptied.get() != node) {
                node.children().stream()
                        .limit(MAX_ELEMENTS)
                        .forEach(child -> array.add(toJson(child, emptied)));
            }
            return array;
        }
        return switch (node.scalar().orElse(null)) {
            case null -> json.nullNode();
            case Long number -> json.numberNode(number);
            case Double number when isWholeBeyondLong(number) ->
                    json.numberNode(new BigDecimal(number).toBigInteger());
            case Double number -> json.numberNode(number);
            case Boolean truth -> json.booleanNode(truth);
            case Object text -> json.stringNode((String) text);
        };
    }

    /**
     * Returns whether a number is whole and exceeds 64 bits. Such a number is passed to the library
     * as a big integer, because its comparison would overflow.
     */
    private static boolean isWholeBeyondLong(double number) {
        return Double.isFinite(number) && Math.abs(number) >= 0x1p63;
    }

    private static String resource(String name) {
        try (InputStream in = SchemaCheck.class.getResourceAsStream(name)) {
            if (in == null) {
                throw new IllegalStateException(name + " is not on the class path");
            }
            return new String(in.readAllBytes(), StandardCharsets.UTF_8);
        } catch (IOException e) {
            throw new UncheckedIOException("cannot read resource " + name, e);
        }
    }
}
