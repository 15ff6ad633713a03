// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import dev.cel.common.CelFunctionDecl;
import dev.cel.common.CelOverloadDecl;
import dev.cel.common.types.CelType;
import dev.cel.common.types.ListType;
import dev.cel.common.types.SimpleType;
import dev.cel.runtime.CelFunctionBinding;

import java.util.ArrayList;
import java.util.List;
import java.util.function.DoubleBinaryOperator;

/**
 * Operators and functions that extend the language CEL. The operators have an integer and a real
 * operand. The functions operate on vectors, which are lists of numbers. Sums add the components
 * from the first to the last, so that results are the same on every machine.
 */
final class Functions {
    private static final CelType VECTOR = ListType.create(SimpleType.DYN);
    private static final CelType RESULT = ListType.create(SimpleType.DOUBLE);

    private Functions() {}

    private record Operator(String symbol, String name, DoubleBinaryOperator of) {}

    private static final List<Operator> MIXED =
            List.of(
                    new Operator("_+_", "add", (a, b) -> a + b),
                    new Operator("_-_", "subtract", (a, b) -> a - b),
                    new Operator("_*_", "multiply", (a, b) -> a * b),
                    new Operator("_/_", "divide", (a, b) -> a / b));

    static List<CelFunctionDecl> declarations() {
        List<CelFunctionDecl> all = new ArrayList<>();
        for (Operator operator : MIXED) {
            all.add(
                    CelFunctionDecl.newFunctionDeclaration(
                            operator.symbol,
                            CelOverloadDecl.newGlobalOverload(
                                    operator.name + "_double_int64",
                                    SimpleType.DOUBLE,
                                    SimpleType.DOUBLE,
                                    SimpleType.INT),
                            CelOverloadDecl.newGlobalOverload(
                                    operator.name + "_int64_double",
                                    SimpleType.DOUBLE,
                                    SimpleType.INT,
                                    SimpleType.DOUBLE)));
        }
        for (String comparison : List.of("_==_", "_!=_")) {
            all.add(
                    CelFunctionDecl.newFunctionDeclaration(
                            comparison,
                            CelOverloadDecl.newGlobalOverload(
                                    comparison + "double_int64",
                                    SimpleType.BOOL,
                                    SimpleType.DOUBLE,
                                    SimpleType.INT),
                            CelOverloadDecl.newGlobalOverload(
                                    comparison + "int64_double",
                                    SimpleType.BOOL,
                                    SimpleType.INT,
                                    SimpleType.DOUBLE)));
        }
        all.add(function("norm", SimpleType.DOUBLE, VECTOR));
        all.add(function("distance", SimpleType.DOUBLE, VECTOR, VECTOR));
        all.add(function("dot", SimpleType.DOUBLE, VECTOR, VECTOR));
        all.add(function("add", RESULT, VECTOR, VECTOR));
        all.add(function("subtract", RESULT, VECTOR, VECTOR));
        all.add(function("scale", RESULT, VECTOR, SimpleType.DYN));
        all.add(function("rotate", RESULT, VECTOR, VECTOR));
        return all;
    }

    static List<CelFunctionBinding> bindings() {
        List<CelFunctionBinding> all = new ArrayList<>();
        for (Operator operator : MIXED) {
            all.add(
                    CelFunctionBinding.from(
                            operator.name + "_double_int64",
                            Double.class,
                            Long.class,
                            (a, b) -> operator.of.applyAsDouble(a, b)));
            all.add(
                    CelFunctionBinding.from(
                            operator.name + "_int64_double",
                            Long.class,
                            Double.class,
                            (a, b) -> operator.of.applyAsDouble(a, b)));
        }
        for (boolean equal : new boolean[] {true, false}) {
            String comparison = equal ? "_==_" : "_!=_";
            all.add(
                    CelFunctionBinding.from(
                            comparison + "double_int64",
                            Double.class,
                            Long.class,
                            (a, b) -> (a.doubleValue() == b.doubleValue()) == equal));
            all.add(
                    CelFunctionBinding.from(
                            comparison + "int64_double",
                            Long.class,
                            Double.class,
                            (a, b) -> (a.doubleValue() == b.doubleValue()) == equal));
        }
        all.add(CelFunctionBinding.from("norm", List.class, v -> norm(vector(v))));
        all.add(
                CelFunctionBinding.from(
                        "distance",
                        List.class,
                        List.class,
                        (a, b) -> norm(each(vector(a), vector(b), (x, y) -> y - x))));
        all.add(
                CelFunctionBinding.from(
                        "dot",
                        List.class,
                        List.class,
                        (a, b) -> sum(each(vector(a), vector(b), (x, y) -> x * y))));
        all.add(
                CelFunctionBinding.from(
                        "add",
                        List.class,
                        List.class,
                        (a, b) -> list(each(vector(a), vector(b), Double::sum))));
        all.add(
                CelFunctionBinding.from(
                        "subtract",
                        List.class,
                        List.class,
                        (a, b) -> list(each(vector(a), vector(b), (x, y) -> x - y))));
        all.add(
                CelFunctionBinding.from(
                        "scale",
                        List.class,
                        Number.class,
                        (v, k) -> list(scaled(vector(v), k.doubleValue()))));
        all.add(
                CelFunctionBinding.from(
                        "rotate",
                        List.class,
                        List.class,
                        (q, v) -> list(rotated(vector(q), vector(v)))));
        return all;
    }

    private static CelFunctionDecl function(String name, CelType result, CelType... arguments) {
        return CelFunctionDecl.newFunctionDeclaration(
                name, CelOverloadDecl.newGlobalOverload(name, result, arguments));
    }

    private static double[] vector(List<?> list) {
        double[] vector = new double[list.size()];
        for (int i = 0; i < vector.length; i++) {
            if (!(list.get(i) instanceof Number number)) {
                throw new IllegalArgumentException(
                        "expected a list of numbers, found a "
                                + "list with something else at ["
                                + i
                                + "]");
            }
            vector[i] = number.doubleValue();
        }
        return vector;
    }

    private static List<Double> list(double[] vector) {
        List<Double> list = new ArrayList<>(vector.length);
        for (double component : vector) {
            list.add(component);
        }
        return list;
    }

    private static double[] each(double[] a, double[] b, DoubleBinaryOperator of) {
        if (a.length != b.length) {
            throw new IllegalArgumentException(
                    "expected vectors of one length, found "
                            + a.length
                            + " and "
                            + b.length
                            + " components");
        }
        double[] result = new double[a.length];
        for (int i = 0; i < result.length; i++) {
            result[i] = of.applyAsDouble(a[i], b[i]);
        }
        return result;
    }

    private static double sum(double[] v) {
        double sum = 0;
        for (double component : v) {
            sum += component;
        }
        return sum;
    }

    private static double norm(double[] v) {
        return Math.sqrt(sum(each(v, v, (x, y) -> x * y)));
    }

    private static double[] scaled(double[] v, double factor) {
        double[] result = v.clone();
        for (int i = 0; i < result.length; i++) {
            result[i] *= factor;
        }
        return result;
    }

    /**
     * Returns a vector v rotated by a unit quaternion with the vector part q and the real part w: v
     * + 2 w (q x v) + 2 q x (q x v).
     */
    private static double[] rotated(double[] q, double[] v) {
        if (q.length != 4 || v.length != 3) {
            throw new IllegalArgumentException(
                    "expected a quaternion of 4 and a vector of 3 "
                            + "components, found "
                            + q.length
                            + " and "
                            + v.length);
        }
        double[] t = scaled(cross(q, v), 2);
        double[] u = cross(q, t);
        double[] result = new double[3];
        for (int i = 0; i < 3; i++) {
            result[i] = v[i] + q[3] * t[i] + u[i];
        }
        return result;
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }
}
