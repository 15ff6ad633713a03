// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import dev.cel.common.CelAbstractSyntaxTree;
import dev.cel.common.ast.CelExpr;
import dev.cel.common.ast.CelExpr.ExprKind.Kind;

import reve.core.unit.Unit;
import reve.core.world.PropertyDescriptor;
import reve.core.world.SymbolDescriptor;

import java.util.List;
import java.util.Optional;

/**
 * Inference of the unit of an expression's result from the units of the names that it reads. A
 * number in the text has no unit of its own. A sum with such a number has the unit of its other
 * operand. A product with such a number has no known unit, because the number may stand for a
 * quantity, as 9.81 does.
 */
final class ResultUnit {
    private static final Unit METRE = Unit.parse("m");
    private static final Unit CUBIC_METRE = Unit.parse("m^3");

    private final KindNames kind;

    private ResultUnit(KindNames kind) {
        this.kind = kind;
    }

    /**
     * Returns the SI unit of the result. Empty if the result has no numbers, or its unit does not
     * follow from the expression.
     *
     * @param kind the names of the item's own aspects
     */
    static Optional<Unit> of(CelAbstractSyntaxTree ast, KindNames kind) {
        try {
            return new ResultUnit(kind).unit(ast.getExpr());
        } catch (IllegalArgumentException outOfRange) {
            return Optional.empty();
        }
    }

    private Optional<Unit> unit(CelExpr expr) {
        return switch (expr.getKind()) {
            case IDENT -> symbol(expr.ident().name());
            case SELECT -> selected(expr.select().operand(), expr.select().field());
            case CALL -> called(expr.call().function(), Cost.operands(expr));
            default -> Optional.empty();
        };
    }

    private Optional<Unit> symbol(String name) {
        String owner = KindNames.SEMANTIC + ".";
        return name.startsWith(owner)
                ? Optional.ofNullable(kind.symbols().get(name.substring(owner.length())))
                        .map(SymbolDescriptor::unit)
                        .map(Unit::si)
                : Optional.empty();
    }

    private Optional<Unit> selected(CelExpr operand, String field) {
        String owner = operand.getKind() == Kind.IDENT ? operand.ident().name() : "";
        return switch (owner) {
            case KindNames.PHYSICS ->
                    Optional.ofNullable(kind.property(field))
                            .map(PropertyDescriptor::unit)
                            .map(Unit::si);
            case KindNames.PHYSICAL ->
                    switch (field) {
                        case "location", "size" -> Optional.of(METRE);
                        case KindNames.VOLUME -> Optional.of(CUBIC_METRE);
                        default -> Optional.empty();
                    };
            default -> Optional.empty();
        };
    }

    private Optional<Unit> called(String function, List<CelExpr> operands) {
        return switch (function) {
            case "-_", "norm", "math.abs", "_[_]", "rotate" ->
                    unit(function.equals("rotate") ? operands.getLast() : operands.getFirst());
            case "_+_", "_-_", "add", "subtract", "distance" ->
                    common(operands.getFirst(), operands.getLast());
            case "_?_:_" -> common(operands.get(1), operands.get(2));
            case "_*_", "dot", "scale" ->
                    both(operands.getFirst(), operands.getLast(), Unit::times);
            case "_/_" -> both(operands.getFirst(), operands.getLast(), Unit::per);
            default -> Optional.empty();
        };
    }

    /** Returns the unit that both operands have. An operand may also be a number of the text. */
    private Optional<Unit> common(CelExpr left, CelExpr right) {
        if (isNumber(left)) {
            return unit(right);
        }
        Optional<Unit> unit = unit(left);
        return isNumber(right)
                ? unit
                : unit.filter(own -> unit(right).filter(own::sameDimension).isPresent());
    }

    private static boolean isNumber(CelExpr expr) {
        return switch (expr.getKind()) {
            case CONSTANT -> true;
            case LIST -> expr.list().elements().stream().allMatch(ResultUnit::isNumber);
            case CALL ->
                    expr.call().function().equals("-_") && isNumber(Cost.operands(expr).getFirst());
            default -> false;
        };
    }

    /** A function that combines the units of two operands. */
    private interface Combination {
        Unit of(Unit left, Unit right);
    }

    private Optional<Unit> both(CelExpr left, CelExpr right, Combination combination) {
        Optional<Unit> first = unit(left);
        Optional<Unit> second = unit(right);
        return first.isPresent() && second.isPresent()
                ? Optional.of(combination.of(first.get(), second.get()))
                : Optional.empty();
    }
}
