// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.Function;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * A repeated item whose texts contain formulas in braces: {@code node-{i+1}}. The value of a text
 * that consists of one formula is the number or list of numbers that the formula gives. {@code {{}
 * and {@code }}} are literal braces.
 */
final class Template {
    /** Maximum length of a text that formulas produce [characters]. */
    static final int MAX_TEXT = 4096;

    /** Number of characters of a text that cost as much as one formula in {@link #formulas}. */
    private static final int CHARACTERS_OF_A_FORMULA = 64;

    private static final Pattern PIECE =
            Pattern.compile("(\\{\\{|\\}\\})|\\{([^{}]*)\\}|([{}])|[^{}]+");

    /**
     * Number of values of a mapping or list that do not count in {@link #size} when they are
     * copied.
     */
    private static final int FREE_CHILDREN = 8;

    /** A function that creates one value of the item for a repetition. */
    private interface Maker {
        Node make(double[] variables, long number);
    }

    /** A value of the item that contains formulas, and the name of its aspect. */
    private record Part(String aspect, Maker maker) {}

    /**
     * A value that formulas give, in one repetition.
     *
     * @param aspect name of the aspect that contains the value; empty for a value of the item
     *     itself, such as the name
     * @param value node with the key and the value
     */
    record Made(String aspect, Node value) {}

    private final List<String> variables;
    private final Problems problems;
    private final long firstNumber;
    private final Maker maker;
    private final List<Part> parts = new ArrayList<>();
    private int made;
    private long formulas;

    /**
     * Reads the formulas of an item, and records their problems.
     *
     * @param variables names that formulas may use
     */
    Template(Node item, List<String> variables, Problems problems) {
        this(item, variables, problems, 0);
    }

    /**
     * Reads the formulas of an item, and records their problems.
     *
     * @param firstNumber number of the first repetition; random numbers depend on it
     */
    Template(Node item, List<String> variables, Problems problems, long firstNumber) {
        this.variables = variables;
        this.problems = problems;
        this.firstNumber = firstNumber;
        this.maker = item(item);
    }

    /** Returns the number of values that are created or copied for each repetition. */
    int size() {
        return made;
    }

    /**
     * Returns the cost of each repetition in formula evaluations. A long formula or text counts as
     * several evaluations.
     */
    long formulas() {
        return formulas;
    }

    /**
     * Returns the item of one repetition. Records a problem if a formula has no value.
     *
     * @param values values of the variables
     * @param number number of the repetition, from 0
     */
    Node make(double[] values, long number) {
        return maker.make(values, number);
    }

    /**
     * Returns only those values of a repetition that formulas give. The method is otherwise like
     * {@link #make}.
     */
    List<Made> makeParts(double[] values, long number) {
        List<Made> all = new ArrayList<>(parts.size());
        for (Part part : parts) {
            all.add(new Made(part.aspect, part.maker.make(values, number)));
        }
        return all;
    }

    /** Returns the mapping without the values that contain formulas. */
    static Node withoutFormulas(Node mapping) {
        if (!hasFormula(mapping)) {
            return mapping;
        }
        Map<String, Node> fields = new LinkedHashMap<>();
        for (Node value : mapping.children()) {
            if (value.isMapping()) {
                fields.put(value.key(), withoutFormulas(value));
            } else if (!hasFormula(value)) {
                fields.put(value.key(), value);
            }
        }
        return mapping.withValue(fields);
    }

    /** Returns whether the value or a nested value contains a formula. */
    static boolean hasFormula(Node node) {
        return node.text().filter(text -> text.indexOf('{') >= 0).isPresent()
                || node.children().stream().anyMatch(Template::hasFormula);
    }

    private Maker item(Node item) {
        return composed(
                item,
                child ->
                        child.isMapping()
                                ? composed(child, value -> part(child.key(), value))
                                : part("", child));
    }

    private Maker part(String aspect, Node value) {
        int before = made;
        Maker valueMaker = maker(value);
        if (made > before) {
            parts.add(new Part(aspect, valueMaker));
        }
        return valueMaker;
    }

    private Maker composed(Node node, Function<Node, Maker> makerOf) {
        int before = made;
        List<Maker> makers = node.children().stream().map(makerOf).toList();
        if (made == before) {
            return (values, number) -> node;
        }
        made += Math.max(1, makers.size() - FREE_CHILDREN);
        return node.isMapping() ? mapping(node, makers) : list(node, makers);
    }

    private Maker maker(Node node) {
        if (node.isMapping() || node.isList()) {
            return composed(node, this::maker);
        }
        return node.text()
                .filter(text -> text.indexOf('{') >= 0 || text.indexOf('}') >= 0)
                .map(text -> text(node, text))
                .orElse((values, number) -> node);
    }

    private static Maker mapping(Node node, List<Maker> makers) {
        List<String> keys = node.children().stream().map(Node::key).toList();
        return (values, number) -> {
            Map<String, Node> fields = LinkedHashMap.newLinkedHashMap(keys.size());
            for (int i = 0; i < makers.size(); i++) {
                fields.put(keys.get(i), makers.get(i).make(values, number));
            }
            return node.withValue(fields);
        };
    }

    private static Maker list(Node node, List<Maker> makers) {
        return (values, number) -> {
            List<Node> elements = new ArrayList<>(makers.size());
            for (Maker maker : makers) {
                elements.add(maker.make(values, number));
            }
            return node.withValue(elements);
        };
    }

    private Maker text(Node node, String text) {
        made++;
        formulas += text.length() / CHARACTERS_OF_A_FORMULA;
        List<Object> pieces = new ArrayList<>();
        Matcher piece = PIECE.matcher(text);
        while (piece.find()) {
            if (piece.group(3) != null) {
                problems.add(
                        node,
                        node.label()
                                + ": `"
                                + piece.group(3)
                                + "` stands alone; a formula is `{…}`, a plain brace is written"
                                + " twice");
            } else if (piece.group(2) != null) {
                formula(node, piece.group(2), pieces);
            } else {
                pieces.add(piece.group(1) == null ? piece.group() : piece.group().substring(1));
            }
        }
        boolean number =
                pieces.size() == 1
                        && pieces.getFirst() instanceof Formula
                        && !node.key().equals("name")
                        && !node.key().equals("parent");
        return number
                ? (values, repetition) ->
                        number(node, (Formula) pieces.getFirst(), values, repetition)
                : (values, repetition) -> joined(node, pieces, values, repetition);
    }

    private void formula(Node node, String text, List<Object> pieces) {
        formulas++;
        try {
            pieces.add(Formula.parse(text, variables));
        } catch (IllegalArgumentException wrong) {
            problems.add(
                    node,
                    node.label() + ": formula `" + Node.shorten(text) + "` " + wrong.getMessage());
        }
    }

    private Node number(Node node, Formula formula, double[] variableValues, long repetition) {
        double[] value = value(node, formula, variableValues, repetition);
        return value.length == 1 ? node.withValue(value[0]) : node.withNumbers(value);
    }

    private Node joined(Node node, List<Object> pieces, double[] variableValues, long repetition) {
        var text = new StringBuilder();
        for (Object piece : pieces) {
            if (piece instanceof Formula formula) {
                String gap = "";
                for (double number : value(node, formula, variableValues, repetition)) {
                    text.append(gap).append(YamlWriter.Numeral.of(number).text());
                    gap = " ";
                }
            } else {
                text.append(piece);
            }
            if (text.length() > MAX_TEXT) {
                problems.add(
                        node,
                        node.label()
                                + ": formulas make a text of more than "
                                + MAX_TEXT
                                + " characters"
                                + where(variableValues));
                return node.withValue("");
            }
        }
        return node.withValue(text.toString());
    }

    /**
     * Returns the value of a formula, which consists of finite numbers. Records a problem and
     * returns 1 if there is no such value, so that the rest of the item is still checked.
     */
    private double[] value(Node node, Formula formula, double[] variableValues, long repetition) {
        String wrong;
        try {
            double[] value = formula.value(variableValues, firstNumber + repetition);
            int bad = 0;
            while (bad < value.length && Double.isFinite(value[bad])) {
                bad++;
            }
            if (bad == value.length) {
                return value;
            }
            wrong = "is not a finite number";
        } catch (IllegalArgumentException mismatch) {
            wrong = mismatch.getMessage();
        }
        problems.add(
                node,
                node.label()
                        + ": a formula in `"
                        + Node.shorten(node.text().orElse(""))
                        + "` "
                        + wrong
                        + where(variableValues));
        return new double[] {1};
    }

    private String where(double[] values) {
        List<String> where = new ArrayList<>();
        for (int i = 0; i < values.length; i++) {
            where.add(variables.get(i) + " = " + YamlWriter.Numeral.of(values[i]).text());
        }
        return where.isEmpty() ? "" : " where " + String.join(", ", where);
    }
}
