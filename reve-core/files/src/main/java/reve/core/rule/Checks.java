// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import dev.cel.common.CelAbstractSyntaxTree;
import dev.cel.common.ast.CelConstant;
import dev.cel.common.ast.CelExpr;
import dev.cel.common.ast.CelExpr.ExprKind.Kind;
import dev.cel.common.navigation.CelNavigableAst;
import dev.cel.common.navigation.CelNavigableExpr;
import dev.cel.common.types.CelKind;
import dev.cel.common.types.CelType;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.OptionalLong;
import java.util.Set;

/**
 * Checks of expressions beyond their types. They refuse expressions that can never be evaluated, or
 * whose cost has no bound.
 */
final class Checks {
    private static final int UNKNOWN = -1;

    private final String text;
    private final CelAbstractSyntaxTree ast;
    private final Map<String, Integer> components;

    /**
     * Names of the loop variables of an expression. A loop variable may have the same name as a
     * value of the scope and then hides it.
     */
    private final Set<String> loops = new HashSet<>();

    private Checks(String text, CelAbstractSyntaxTree ast, Map<String, Integer> components) {
        this.text = text;
        this.ast = ast;
        this.components = components;
    }

    /**
     * Checks an expression before its types are computed. Refuses maps with computed keys, because
     * the size of their types may double with each operator.
     */
    static void parsed(String text, CelAbstractSyntaxTree ast) throws ExpressionException {
        List<CelExpr> computed =
                CelNavigableAst.fromAst(ast)
                        .getRoot()
                        .allNodes()
                        .map(node -> node.expr())
                        .filter(expr -> expr.getKind() == Kind.MAP)
                        .flatMap(expr -> expr.map().entries().stream())
                        .map(CelExpr.CelMap.Entry::key)
                        .filter(key -> key.getKind() != Kind.CONSTANT)
                        .toList();
        if (!computed.isEmpty()) {
            throw new Checks(text, ast, Map.of())
                    .at(
                            computed.getFirst(),
                            "the key of a map is computed, expected a constant such as 'red'");
        }
    }

    /**
     * Checks an expression whose types are known.
     *
     * @param components number of components of each vector name, for example 3 for {@code
     *     physics.velocity}
     */
    static void typed(String text, CelAbstractSyntaxTree ast, Map<String, Integer> components)
            throws ExpressionException {
        var checks = new Checks(text, ast, components);
        List<CelExpr> calls = new ArrayList<>();
        CelNavigableAst.fromAst(ast)
                .getRoot()
                .allNodes()
                .map(node -> node.expr())
                .forEach(
                        expr -> {
                            if (expr.getKind() == Kind.CALL) {
                                calls.add(expr);
                            } else if (expr.getKind() == Kind.COMPREHENSION) {
                                checks.loops.add(expr.comprehension().iterVar());
                            }
                        });
        for (CelExpr call : calls) {
            switch (call.call().function()) {
                case Patterns.FUNCTION -> checks.pattern(Cost.operands(call).getLast());
                case "_[_]" -> checks.index(Cost.operands(call));
                default -> {}
            }
        }
    }

    private void pattern(CelExpr pattern) throws ExpressionException {
        try {
            Patterns.size(pattern);
        } catch (IllegalArgumentException refused) {
            throw at(pattern, refused.getMessage());
        }
    }

    private void index(List<CelExpr> operands) throws ExpressionException {
        CelExpr list = operands.getFirst();
        OptionalLong index = constant(operands.getLast());
        int length = length(list);
        boolean known = length != UNKNOWN;
        if (index.isPresent()
                && isList(list)
                && (index.getAsLong() < 0 || known && index.getAsLong() >= length)) {
            throw at(
                    operands.getLast(),
                    "there is no ["
                            + index.getAsLong()
                            + "]: `"
                            + words(list)
                            + "` "
                            + (known
                                    ? "has components: "
                                            + length
                                            + ", expected an index from 0 to "
                                            + (length - 1)
                                    : "expected an index of 0 or more"));
        }
    }

    private boolean isList(CelExpr expr) {
        return kind(expr) == CelKind.LIST;
    }

    private CelKind kind(CelExpr expr) {
        return ast.getType(expr.id()).map(CelType::kind).orElse(CelKind.UNSPECIFIED);
    }

    private static OptionalLong constant(CelExpr index) {
        if (index.getKind() != Kind.CONSTANT) {
            return OptionalLong.empty();
        }
        CelConstant constant = index.constant();
        return switch (constant.getKind()) {
            case INT64_VALUE -> OptionalLong.of(constant.int64Value());
            case UINT64_VALUE -> OptionalLong.of(constant.uint64Value().longValue());
            default -> OptionalLong.empty();
        };
    }

    /** Returns the number of elements of a list, if it is known before the evaluation. */
    private int length(CelExpr expr) {
        return switch (expr.getKind()) {
            case LIST -> expr.list().elements().size();
            case IDENT ->
                    loops.contains(expr.ident().name())
                            ? UNKNOWN
                            : components.getOrDefault(expr.ident().name(), UNKNOWN);
            case SELECT -> {
                String owner =
                        ast.getType(expr.select().operand().id()).map(CelType::name).orElse("");
                yield components.getOrDefault(owner + "." + expr.select().field(), UNKNOWN);
            }
            case CALL ->
                    switch (expr.call().function()) {
                        case "rotate" -> 3;
                        case "add", "subtract", "scale" -> length(expr.call().args().getFirst());
                        default -> UNKNOWN;
                    };
            default -> UNKNOWN;
        };
    }

    private static String words(CelExpr expr) {
        return switch (expr.getKind()) {
            case IDENT -> expr.ident().name();
            case SELECT -> words(expr.select().operand()) + "." + expr.select().field();
            case CALL -> expr.call().function() + "(…)";
            default -> "[…]";
        };
    }

    private ExpressionException at(CelExpr expr, String message) {
        Map<Long, Integer> places = ast.getSource().getPositionsMap();
        int first =
                CelNavigableExpr.fromExpr(expr)
                        .allNodes()
                        .map(CelNavigableExpr::expr)
                        .map(part -> places.getOrDefault(part.id(), Integer.MAX_VALUE))
                        .min(Integer::compare)
                        .orElse(0);
        int characters = text.codePointCount(0, text.length());
        return new ExpressionException(
                text.offsetByCodePoints(0, Math.min(first, characters)), message);
    }
}
