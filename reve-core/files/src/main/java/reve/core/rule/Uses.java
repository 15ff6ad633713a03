// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import dev.cel.common.CelAbstractSyntaxTree;
import dev.cel.common.ast.CelConstant;
import dev.cel.common.ast.CelExpr;
import dev.cel.common.navigation.CelNavigableAst;
import dev.cel.common.navigation.CelNavigableExpr;

import java.util.Set;
import java.util.TreeSet;

/** Search for the names that an expression reads. */
final class Uses {
    private Uses() {}

    /**
     * Returns the full names that an expression reads, in alphabetical order, for example {@code
     * actor.physics.mass} and {@code semantic.lit}.
     */
    static Set<String> of(CelAbstractSyntaxTree ast, Set<String> roots) {
        Set<String> uses = new TreeSet<>();
        CelNavigableAst.fromAst(ast)
                .getRoot()
                .allNodes()
                .forEach(
                        node -> {
                            CelExpr expr = node.expr();
                            if (expr.getKind() == CelExpr.ExprKind.Kind.IDENT) {
                                String name = expr.ident().name();
                                int dot = name.indexOf('.');
                                if (roots.contains(dot < 0 ? name : name.substring(0, dot))) {
                                    uses.add(inFull(node, name));
                                }
                            }
                        });
        return uses;
    }

    /**
     * Extends a name such as {@code semantic} to the full name. Adds the selections around it, such
     * as {@code .lit} or {@code ["lit"]}.
     */
    private static String inFull(CelNavigableExpr node, String name) {
        CelNavigableExpr parent = node.parent().orElse(null);
        if (parent == null) {
            return name;
        }
        CelExpr expr = parent.expr();
        return switch (expr.getKind()) {
            case SELECT -> inFull(parent, name + "." + expr.select().field());
            case CALL ->
                    isIndex(expr, node.expr())
                            ? inFull(
                                    parent,
                                    name + "." + expr.call().args().get(1).constant().stringValue())
                            : name;
            default -> name;
        };
    }

    private static boolean isIndex(CelExpr call, CelExpr indexed) {
        return call.call().function().equals("_[_]")
                && call.call().args().getFirst().id() == indexed.id()
                && call.call().args().get(1).getKind() == CelExpr.ExprKind.Kind.CONSTANT
                && call.call().args().get(1).constant().getKind() == CelConstant.Kind.STRING_VALUE;
    }
}
