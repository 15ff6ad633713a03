// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.rule.Expression;
import reve.core.rule.ExpressionException;
import reve.core.rule.ExpressionType;
import reve.core.rule.Scope;
import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalDouble;

/** Reader of the measures of an experiment, for the world of one run. */
final class MeasureReader {
    /** The keys of sources. Each measure has exactly one of them. */
    private static final List<String> SOURCES =
            List.of("of", "sum", "mean", "min", "max", "ledger", "energy");

    private static final Unit JOULE = Unit.parse("J");

    private final WorldDescription world;
    private final boolean sampled;
    private final Problems problems;
    private final Quantities quantities;
    private final Map<String, Scope> scopes = new HashMap<>();

    /**
     * @param sampled whether values are also measured during the run, in addition to its end
     */
    MeasureReader(WorldDescription world, boolean sampled, Problems problems) {
        this.world = world;
        this.sampled = sampled;
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /**
     * Reads measures.
     *
     * @param nodes the measures
     * @param expected the expected values by the names of the measures, after the evaluation of
     *     formulas
     */
    List<Measure> readAll(Iterable<Node> nodes, Map<String, Node> expected) {
        List<Measure> measures = new ArrayList<>();
        for (Node node : nodes) {
            read(node, Optional.ofNullable(expected.get(node.key()))).ifPresent(measures::add);
        }
        return measures;
    }

    private Optional<Measure> read(Node node, Optional<Node> expected) {
        Optional<Measure.Source> source = source(node);
        Measure.Take take =
                Measure.Take.valueOf(text(node, "take").orElse("end").toUpperCase(Locale.ROOT));
        if (take != Measure.Take.END && !sampled) {
            problems.add(
                    node.get("take").orElseThrow(),
                    "take: a summary needs measurements during the run, and `every` is missing");
        }
        if (node.get("tolerance").isPresent() && expected.isEmpty()) {
            problems.add(
                    node.get("tolerance").get(),
                    "tolerance: limits the error of a value, and `expected` is missing");
        }
        Optional<Quantities.Quantity> expectedQuantity =
                expected.flatMap(each -> quantities.quantity(each));
        OptionalDouble expectedNumber =
                expectedQuantity.stream().mapToDouble(Quantities.Quantity::value).findFirst();
        OptionalDouble tolerance =
                node
                        .get("tolerance")
                        .flatMap(each -> quantities.number(each, Unit.ONE))
                        .filter(each -> isTolerance(node.get("tolerance").get(), each))
                        .stream()
                        .mapToDouble(each -> each)
                        .findFirst();
        boolean needsNumber = take != Measure.Take.END || expected.isPresent();
        source.ifPresent(each -> requireNumber(node, each, needsNumber));
        if (source.isEmpty()) {
            return Optional.empty();
        }
        Optional<Unit> ofExpected = expectedQuantity.flatMap(Quantities.Quantity::unit);
        Measure measure =
                new Measure(
                        node.key(),
                        Problems.keyPlace(node),
                        source.get(),
                        take,
                        expectedNumber,
                        tolerance,
                        unit(node, source.get())
                                .or(
                                        () ->
                                                take == Measure.Take.PERIOD
                                                        ? Optional.empty()
                                                        : ofExpected.map(Unit::si)));
        requireSame(
                node.get("expected").orElse(node), "expected", ofExpected, measure.unitOfRuns());
        return Optional.of(measure);
    }

    /**
     * Returns the unit in which plots show the measured values: the unit in the file, or the SI
     * unit of the source.
     */
    private Optional<Unit> unit(Node node, Measure.Source source) {
        Optional<Unit> known =
                switch (source) {
                    case Measure.OfItem of -> of.expression().unit();
                    case Measure.OfKind of -> of.expression().unit();
                    case Measure.OfLedger of -> Optional.of(of.value().unit());
                    case Measure.Energy _ -> Optional.of(JOULE);
                };
        Optional<Node> given = node.get("unit");
        if (given.flatMap(Node::text).isEmpty()) {
            return known;
        }
        try {
            Optional<Unit> unit = given.flatMap(Node::text).map(Unit::parse);
            requireSame(given.get(), "unit", unit, known);
            return unit;
        } catch (IllegalArgumentException noUnit) {
            problems.add(given.get(), "unit: " + noUnit.getMessage());
            return known;
        }
    }

    private void requireSame(Node node, String key, Optional<Unit> found, Optional<Unit> known) {
        if (found.isPresent() && known.isPresent() && !found.get().sameDimension(known.get())) {
            problems.add(
                    node,
                    key
                            + ": unit "
                            + found.get()
                            + " does not fit the measured value, which is in "
                            + known.get());
        }
    }

    private boolean isTolerance(Node node, double value) {
        if (value >= 0) {
            return true;
        }
        problems.add(node, "tolerance: found " + value + ", expected 0 or more");
        return false;
    }

    private void requireNumber(Node node, Measure.Source source, boolean needed) {
        ExpressionType type =
                switch (source) {
                    case Measure.OfItem of -> of.expression().type();
                    case Measure.OfKind of -> of.expression().type();
                    case Measure.OfLedger of ->
                            isVector(of.value()) ? ExpressionType.LIST : ExpressionType.NUMBER;
                    case Measure.Energy energy -> ExpressionType.NUMBER;
                };
        if ((needed || source instanceof Measure.OfKind) && !type.suits(ExpressionType.NUMBER)) {
            Node at = node.get("is").or(() -> node.get("ledger")).orElse(node);
            problems.add(
                    at, at.label() + ": is " + type.words() + ", expected a number to summarize");
        }
    }

    private static boolean isVector(Measure.LedgerValue value) {
        return value == Measure.LedgerValue.MOMENTUM
                || value == Measure.LedgerValue.ANGULAR_MOMENTUM;
    }

    private Optional<Measure.Source> source(Node node) {
        List<String> found = SOURCES.stream().filter(key -> node.get(key).isPresent()).toList();
        if (found.size() != 1) {
            problems.addAtKey(
                    node,
                    node.label()
                            + ": found "
                            + (found.isEmpty() ? "none" : String.join(" and ", found))
                            + ", expected one of "
                            + String.join(", ", SOURCES));
            return Optional.empty();
        }
        String key = found.getFirst();
        boolean expressed = !key.equals("ledger") && !key.equals("energy");
        if (expressed != node.get("is").isPresent()) {
            problems.addAtKey(
                    node,
                    node.label()
                            + ": "
                            + (expressed
                                    ? "`is` is missing, the expression of the value"
                                    : "`is` does not go with `" + key + "`"));
            return Optional.empty();
        }
        if (node.get("class").isPresent() && (!expressed || key.equals("of"))) {
            problems.add(
                    node.get("class").get(),
                    "class: selects among the items of a kind, with sum, mean, min or max");
        }
        Node value = node.get(key).get();
        return switch (key) {
            case "of" -> ofItem(node, value);
            case "ledger" -> ofLedger(value);
            case "energy" ->
                    Optional.of(
                            new Measure.Energy(
                                    Measure.EnergyPart.valueOf(
                                            value.text().orElseThrow().toUpperCase(Locale.ROOT))));
            default -> ofKind(node, value, Measure.Fold.valueOf(key.toUpperCase(Locale.ROOT)));
        };
    }

    private Optional<Measure.Source> ofItem(Node node, Node value) {
        String item = value.text().orElse("");
        Optional<ItemDefinition> found =
                world.items().stream().filter(each -> each.name().equals(item)).findFirst();
        if (found.isEmpty()) {
            problems.add(
                    value,
                    "of: no item is named `"
                            + Node.shorten(item)
                            + "`"
                            + problems.suggestion(
                                    item,
                                    world.items().stream().map(ItemDefinition::name).toList()));
            return Optional.empty();
        }
        return expression(node.get("is").orElseThrow(), found.get().kind())
                .map(expression -> new Measure.OfItem(item, expression));
    }

    private Optional<Measure.Source> ofKind(Node node, Node value, Measure.Fold fold) {
        String kind = value.text().orElse("");
        if (!world.prototype().hasKind(kind)) {
            problems.add(
                    value,
                    value.label()
                            + ": there is no kind `"
                            + Node.shorten(kind)
                            + "`"
                            + problems.suggestion(kind, world.prototype().kinds()));
            return Optional.empty();
        }
        return expression(node.get("is").orElseThrow(), kind)
                .map(expression -> new Measure.OfKind(fold, kind, text(node, "class"), expression));
    }

    private Optional<Measure.Source> ofLedger(Node value) {
        String text = value.text().orElse("");
        int dot = text.lastIndexOf('.');
        String name = text.substring(dot + 1);
        Optional<Measure.LedgerValue> found =
                Arrays.stream(Measure.LedgerValue.values())
                        .filter(each -> each.key().equals(name))
                        .findFirst();
        if (dot < 1 || found.isEmpty()) {
            List<String> known =
                    Arrays.stream(Measure.LedgerValue.values())
                            .map(Measure.LedgerValue::key)
                            .toList();
            problems.add(
                    value,
                    "ledger: found `"
                            + Node.shorten(text)
                            + "`, expected LINE.VALUE such as total.energy; the values are "
                            + String.join(", ", known)
                            + problems.suggestion(name, known));
            return Optional.empty();
        }
        return Optional.of(new Measure.OfLedger(text.substring(0, dot), found.get()));
    }

    private Optional<Expression> expression(Node node, String kind) {
        try {
            return Optional.of(
                    scopes.computeIfAbsent(kind, known -> Scope.ofItem(world.prototype(), known))
                            .compile(node.text().orElse("")));
        } catch (ExpressionException refused) {
            problems.addInText(node, refused.offset(), node.label() + ": " + refused.getMessage());
            return Optional.empty();
        }
    }

    private static Optional<String> text(Node node, String key) {
        return node.get(key).flatMap(Node::text);
    }
}
