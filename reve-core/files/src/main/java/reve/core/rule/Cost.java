// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import dev.cel.common.CelAbstractSyntaxTree;
import dev.cel.common.ast.CelExpr;

import java.util.ArrayList;
import java.util.List;

/**
 * The structure of one expression: the order of its parts, and the use of each part's value. A
 * {@link Meter} computes the cost of an evaluation from this structure. Immutable.
 */
final class Cost {
    /** The way in which the enclosing part of the expression uses the value of a part. */
    enum Role {
        /** Role of a value that the enclosing part may read completely. */
        READ,
        /** Role of a value of which the enclosing part selects one element. */
        PICKED,
        /** Role of a value whose elements the enclosing part compares with another value. */
        MEMBERS,
        /**
         * Role of a value over which the enclosing part is a loop. The loop fails if the value is
         * no list or map.
         */
        RANGE,
        /**
         * Role of a value that must be true or false, because the enclosing part fails otherwise.
         */
        TRUTH,
        /** Role of a text in which the enclosing part searches a pattern. */
        MATCHED,
        /** Role of a text in which the enclosing part searches another text. */
        HAYSTACK,
        /**
         * Role of a text that the enclosing part searches in a text with the role {@link
         * #HAYSTACK}.
         */
        NEEDLE
    }

    /**
     * One part of the expression, such as an operator with its operands.
     *
     * @param next the part that is evaluated next unless the enclosing part fails; 0 if values
     *     determine the next part
     * @param depth number of enclosing parts
     * @param detail for MATCHED, the size of the pattern; for a HAYSTACK and its NEEDLE, a serial
     *     number that both have
     */
    record Part(int next, int depth, Role role, int detail) {}

    private static final Part UNKNOWN = new Part(0, 0, Role.READ, 0);

    private final CelAbstractSyntaxTree ast;
    private final List<Part> parts = new ArrayList<>();
    private int haystacks;

    Cost(CelAbstractSyntaxTree ast) {
        this.ast = ast;
        visit(ast.getExpr(), 0, 0, Role.READ, 0);
    }

    Part part(long id) {
        return id < parts.size() ? parts.get((int) id) : UNKNOWN;
    }

    /** Returns the number of parts with the role HAYSTACK. */
    int haystacks() {
        return haystacks;
    }

    private void visit(CelExpr expr, int next, int depth, Role role, int detail) {
        int id = (int) expr.id();
        while (parts.size() <= id) {
            parts.add(UNKNOWN);
        }
        parts.set(id, new Part(next, depth, role, detail));
        switch (expr.getKind()) {
            case SELECT -> {
                if (!isName(expr)) {
                    visit(expr.select().operand(), id, depth + 1, Role.PICKED, 0);
                }
            }
            case CALL -> call(expr, id, depth + 1);
            case LIST -> inOrder(expr.list().elements(), id, depth + 1);
            case MAP -> inOrder(entries(expr), id, depth + 1);
            case COMPREHENSION -> {
                var loop = expr.comprehension();
                visit(loop.iterRange(), 0, depth + 1, Role.RANGE, 0);
                visit(loop.accuInit(), 0, depth + 1, Role.READ, 0);
                visit(loop.loopCondition(), 0, depth + 1, Role.TRUTH, 0);
                visit(loop.loopStep(), 0, depth + 1, Role.READ, 0);
                visit(loop.result(), id, depth + 1, Role.READ, 0);
            }
            default -> {}
        }
    }

    private void call(CelExpr expr, int id, int depth) {
        List<CelExpr> operands = operands(expr);
        switch (expr.call().function()) {
            case "_||_", "_&&_" ->
                    operands.forEach(operand -> visit(operand, 0, depth, Role.TRUTH, 0));
            case "_?_:_" -> {
                visit(operands.getFirst(), 0, depth, Role.TRUTH, 0);
                visit(operands.get(1), id, depth, Role.READ, 0);
                visit(operands.get(2), id, depth, Role.READ, 0);
            }
            case "@not_strictly_false" -> visit(operands.getFirst(), 0, depth, Role.READ, 0);
            case "_[_]" -> two(operands, id, depth, Role.PICKED, Role.READ, 0);
            case "@in" -> two(operands, id, depth, Role.READ, Role.MEMBERS, 0);
            case "contains" -> two(operands, id, depth, Role.HAYSTACK, Role.NEEDLE, haystacks++);
            case Patterns.FUNCTION ->
                    two(
                            operands,
                            id,
                            depth,
                            Role.MATCHED,
                            Role.READ,
                            Patterns.size(operands.getLast()));
            default -> inOrder(operands, id, depth);
        }
    }

    private void two(
            List<CelExpr> operands, int owner, int depth, Role first, Role second, int detail) {
        visit(operands.getFirst(), first(operands.getLast()), depth, first, detail);
        visit(operands.getLast(), owner, depth, second, detail);
    }

    private void inOrder(List<CelExpr> all, int owner, int depth) {
        for (int i = 0; i < all.size(); i++) {
            visit(
                    all.get(i),
                    i + 1 < all.size() ? first(all.get(i + 1)) : owner,
                    depth,
                    Role.READ,
                    0);
        }
    }

    /**
     * Returns whether a selection such as {@code physics.mass} is a single name that contains dots,
     * and not the selection of a value.
     */
    private boolean isName(CelExpr select) {
        return ast.getReference(select.id()).isPresent();
    }

    /** Returns the id of the part of an expression that is evaluated first. */
    private int first(CelExpr expr) {
        List<CelExpr> inside =
                switch (expr.getKind()) {
                    case SELECT -> isName(expr) ? List.of() : List.of(expr.select().operand());
                    case CALL -> operands(expr);
                    case LIST -> expr.list().elements();
                    case MAP -> entries(expr);
                    case COMPREHENSION -> List.of(expr.comprehension().iterRange());
                    default -> List.of();
                };
        return inside.isEmpty() ? (int) expr.id() : first(inside.getFirst());
    }

    private static List<CelExpr> entries(CelExpr map) {
        List<CelExpr> all = new ArrayList<>();
        map.map()
                .entries()
                .forEach(
                        entry -> {
                            all.add(entry.key());
                            all.add(entry.value());
                        });
        return all;
    }

    /** Returns the operands of a call, with its target first. */
    static List<CelExpr> operands(CelExpr call) {
        List<CelExpr> operands = new ArrayList<>();
        call.call().target().ifPresent(operands::add);
        operands.addAll(call.call().args());
        return operands;
    }
}
