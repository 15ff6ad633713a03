// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.rule.Expression;
import reve.core.rule.ExpressionException;
import reve.core.rule.ExpressionType;
import reve.core.rule.Rule;
import reve.core.rule.Scope;
import reve.core.rule.SymbolSource;
import reve.core.unit.Unit;
import reve.core.world.StandardSymbols;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Reader of the types of semantic symbols, and of the rules that compute them. */
final class RuleReader {
    /** Maximum number of rules of one world, and also of symbols with a declared type. */
    static final int MAX_RULES = 1000;

    private final Problems problems;
    private final ProviderReader providers;

    RuleReader(Problems problems) {
        this.problems = problems;
        this.providers = new ProviderReader(problems);
    }

    /** Returns the prototype with the declared symbols. */
    WorldPrototype readSymbols(List<Node> symbols, WorldPrototype prototype)
            throws WorldFileException {
        problems.requireAtMost(MAX_RULES, symbols, "symbols");
        List<SymbolDescriptor> declared = new ArrayList<>();
        Map<String, Node> first = new LinkedHashMap<>();
        for (Node node : symbols) {
            if (isNew(node, first, "symbol")) {
                PrototypeReader.unit(node, problems)
                        .flatMap(unit -> symbol(node, unit))
                        .ifPresent(declared::add);
            }
        }
        return prototype.withSymbols(declared);
    }

    /** Returns all rules, in the order of the file. */
    List<Rule> readRules(List<Node> nodes, WorldPrototype prototype) throws WorldFileException {
        problems.requireAtMost(MAX_RULES, nodes, "rules");
        List<Rule> rules = new ArrayList<>();
        Map<String, Node> first = new LinkedHashMap<>();
        Map<String, Scope> scopes = new HashMap<>();
        for (Node node : nodes) {
            if (isNew(node, first, "rule")) {
                rule(node, prototype, scopes).ifPresent(rules::add);
            }
        }
        requireOrder(rules, first);
        return rules;
    }

    private boolean isNew(Node node, Map<String, Node> first, String what) {
        Node before = first.putIfAbsent(node.key(), node);
        if (before != null) {
            problems.addAtKey(
                    node,
                    "duplicate "
                            + what
                            + " `"
                            + Node.shorten(node.key())
                            + "`, first "
                            + Problems.place(before, node));
        }
        return before == null;
    }

    private Optional<SymbolDescriptor> symbol(Node node, Unit unit) {
        SymbolType type =
                switch (node.get("type").flatMap(Node::text).orElse("text")) {
                    case "number" -> SymbolType.NUMBER;
                    case "truth" -> SymbolType.TRUTH;
                    case "list" -> SymbolType.LIST;
                    default -> SymbolType.TEXT;
                };
        try {
            return Optional.of(new SymbolDescriptor(node.key(), type, unit, doc(node)));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    private Optional<Rule> rule(Node node, WorldPrototype prototype, Map<String, Scope> scopes) {
        Optional<Node> is = node.isMapping() ? node.get("is") : Optional.of(node);
        Optional<Node> java = node.isMapping() ? node.get(ProviderReader.JAVA) : Optional.empty();
        if (is.isPresent() == java.isPresent()) {
            if (!problems.isMisspelt(node)) {
                problems.add(
                        node,
                        node.label()
                                + ": found "
                                + (is.isPresent() ? "both" : "neither")
                                + ", expected one of `is` and `java`");
            }
            return Optional.empty();
        }
        String kind = node.get("kind").flatMap(Node::text).orElse(WorldPrototype.BODY);
        if (!prototype.hasKind(kind)) {
            problems.add(
                    node.get("kind").orElseThrow(),
                    "kind: there is no kind `"
                            + kind
                            + "`"
                            + problems.suggestion(kind, prototype.kinds()));
            return Optional.empty();
        }
        if (java.isPresent()) {
            return providers
                    .symbol(java.get())
                    .flatMap(
                            provider ->
                                    rule(
                                            node,
                                            kind,
                                            new SymbolSource.Provided(provider),
                                            prototype));
        }
        Scope scope = scopes.computeIfAbsent(kind, known -> Scope.ofItem(prototype, known));
        return is.filter(text -> text.text().isPresent())
                .flatMap(text -> expression(text, scope, type(prototype, node.key())))
                .flatMap(
                        expression ->
                                rule(node, kind, new SymbolSource.Formula(expression), prototype));
    }

    private Optional<Rule> rule(
            Node node, String kind, SymbolSource source, WorldPrototype prototype) {
        if (node.key().equals(StandardSymbols.CLASSES) && !prototype.classes().isEmpty()) {
            problems.addAtKey(node, "symbol classes is a standard one; a rule cannot give it");
            return Optional.empty();
        }
        node.get("class")
                .ifPresent(
                        name ->
                                new ClassValues(prototype, problems)
                                        .warn(name, name.text().orElse(""), kind));
        try {
            return Optional.of(
                    new Rule(
                            node.key(),
                            kind,
                            node.get("class").flatMap(Node::text),
                            source,
                            doc(node)));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    private Optional<Expression> expression(Node node, Scope scope, ExpressionType expected) {
        String text = node.text().orElseThrow();
        try {
            Expression expression = scope.compile(text);
            if (!expression.type().suits(expected)) {
                problems.add(
                        node,
                        node.label()
                                + ": is "
                                + expression.type().words()
                                + ", the symbol is declared as "
                                + expected.words());
                return Optional.empty();
            }
            return Optional.of(expression);
        } catch (ExpressionException refused) {
            problems.addInText(node, refused.offset(), node.label() + ": " + refused.getMessage());
            return Optional.empty();
        }
    }

    private static ExpressionType type(WorldPrototype prototype, String symbol) {
        return prototype
                .symbol(symbol)
                .map(SymbolDescriptor::type)
                .map(
                        type ->
                                switch (type) {
                                    case TEXT -> ExpressionType.TEXT;
                                    case NUMBER -> ExpressionType.NUMBER;
                                    case TRUTH -> ExpressionType.TRUTH;
                                    case LIST -> ExpressionType.LIST;
                                })
                .orElse(ExpressionType.ANY);
    }

    /**
     * Checks that a rule reads only symbols of earlier rules. It must not read its own symbol or
     * symbols of later rules.
     */
    private void requireOrder(List<Rule> rules, Map<String, Node> nodes) {
        misplaced(rules)
                .forEach(each -> problems.addAtKey(nodes.get(each.rule.symbol()), each.message()));
    }

    /** A rule that reads its own symbol or the symbol of a later rule, and this later rule. */
    record Misplaced(Rule rule, Rule later) {
        String message() {
            return "rule "
                    + rule.symbol()
                    + " reads "
                    + (rule == later
                            ? "what it gives itself"
                            : "what rule " + later.symbol() + " gives, which comes later");
        }
    }

    static List<Misplaced> misplaced(List<Rule> rules) {
        Map<String, Integer> places = new HashMap<>();
        for (int i = 0; i < rules.size(); i++) {
            places.put("semantic." + rules.get(i).symbol(), i);
        }
        List<Misplaced> found = new ArrayList<>();
        for (int i = 0; i < rules.size(); i++) {
            Rule rule = rules.get(i);
            int place = i;
            rule.source().uses().stream()
                    .map(name -> places.getOrDefault(name, -1))
                    .filter(later -> later >= place)
                    .sorted()
                    .forEach(later -> found.add(new Misplaced(rule, rules.get(later))));
        }
        return found;
    }

    /**
     * Reads one rule of a change.
     *
     * @param scopes scopes of expressions by kind. All rules of the change share the scopes,
     *     because creating a scope takes longer than reading a rule
     */
    Optional<Rule> readChange(Node node, WorldPrototype prototype, Map<String, Scope> scopes) {
        return rule(node, prototype, scopes);
    }

    private static String doc(Node node) {
        return node.get("doc").flatMap(Node::text).orElse("");
    }
}
