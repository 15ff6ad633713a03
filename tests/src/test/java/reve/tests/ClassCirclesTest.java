// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import com.tngtech.archunit.core.domain.Dependency;
import com.tngtech.archunit.core.domain.JavaClass;

import org.junit.jupiter.api.Test;

import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.SortedMap;
import java.util.SortedSet;
import java.util.TreeMap;
import java.util.TreeSet;

/**
 * Limits the size of circles of classes. In a circle, each class depends on all other classes,
 * directly or indirectly. Therefore a change of one class needs knowledge of all. A nested class
 * counts as a part of its outermost class.
 */
class ClassCirclesTest {
    /** Maximum number of classes in a circle. */
    private static final int LIMIT = 5;

    /** Returns for each class of the project the project's classes on which it depends. */
    private static SortedMap<String, SortedSet<String>> arrows() {
        SortedMap<String, SortedSet<String>> arrows = new TreeMap<>();
        for (JavaClass from : DependencyRulesTest.CLASSES) {
            SortedSet<String> to = arrows.computeIfAbsent(outermost(from), name -> new TreeSet<>());
            for (Dependency dependency : from.getDirectDependenciesFromSelf()) {
                String name = outermost(dependency.getTargetClass().getBaseComponentType());
                if (name.startsWith("reve.") && !name.equals(outermost(from))) {
                    to.add(name);
                }
            }
        }
        return arrows;
    }

    private static String outermost(JavaClass type) {
        String name = type.getName();
        int nested = name.indexOf('$');
        return nested < 0 ? name : name.substring(0, nested);
    }

    @Test
    void noClassIsInALargeCircle() {
        SortedMap<String, SortedSet<String>> arrows = arrows();
        List<String> tooLarge = new ArrayList<>();
        for (SortedSet<String> circle : new Circles(arrows).all()) {
            if (circle.size() > LIMIT) {
                tooLarge.add(describe(circle, arrows));
            }
        }
        assertThat(String.join("\n", tooLarge)).isEmpty();
    }

    /** Returns the innermost package that holds all classes of a circle. */
    private static String packageOf(SortedSet<String> circle) {
        String first = circle.first();
        String last = circle.last();
        int common = 0;
        for (int i = 0; i < Math.min(first.length(), last.length()); i++) {
            if (first.charAt(i) != last.charAt(i)) {
                break;
            }
            common = first.charAt(i) == '.' ? i : common;
        }
        return first.substring(0, common);
    }

    private static String describe(
            SortedSet<String> circle, Map<String, SortedSet<String>> arrows) {
        String inside = packageOf(circle);
        StringBuilder text = new StringBuilder();
        text.append("package ").append(inside).append(": a circle of ").append(circle.size());
        text.append(" classes, expected at most ").append(LIMIT).append("; its arrows are\n");
        for (String from : circle) {
            List<String> to =
                    arrows.get(from).stream()
                            .filter(circle::contains)
                            .map(name -> name.substring(inside.length() + 1))
                            .toList();
            text.append("  ").append(from.substring(inside.length() + 1)).append(" -> ");
            text.append(String.join(", ", to)).append('\n');
        }
        return text.toString();
    }

    @Test
    void circlesAreFoundWhereTheyAre() {
        SortedMap<String, SortedSet<String>> arrows = new TreeMap<>();
        arrows.put("a", new TreeSet<>(List.of("b", "x")));
        arrows.put("b", new TreeSet<>(List.of("c")));
        arrows.put("c", new TreeSet<>(List.of("a", "d")));
        arrows.put("d", new TreeSet<>(List.of("e")));
        arrows.put("e", new TreeSet<>(List.of("d")));
        arrows.put("x", new TreeSet<>());
        assertThat(new Circles(arrows).all())
                .containsExactlyInAnyOrder(
                        new TreeSet<>(List.of("a", "b", "c")), new TreeSet<>(List.of("d", "e")));
        assertThat(packageOf(new TreeSet<>(List.of("r.a.X", "r.a.b.Y", "r.aa.Z")))).isEqualTo("r");
        assertThat(packageOf(new TreeSet<>(List.of("r.a.X", "r.a.Y")))).isEqualTo("r.a");
    }

    /** Strongly connected components of two classes or more (R. E. Tarjan, 1972). */
    private static final class Circles {
        private final Map<String, SortedSet<String>> arrows;
        private final Map<String, Integer> order = new HashMap<>();
        private final Map<String, Integer> earliest = new HashMap<>();
        private final Deque<String> open = new ArrayDeque<>();
        private final List<SortedSet<String>> found = new ArrayList<>();

        Circles(SortedMap<String, SortedSet<String>> arrows) {
            this.arrows = arrows;
        }

        List<SortedSet<String>> all() {
            for (String each : arrows.keySet()) {
                if (!order.containsKey(each)) {
                    visit(each);
                }
            }
            return found;
        }

        private void visit(String one) {
            order.put(one, order.size());
            earliest.put(one, order.get(one));
            open.push(one);
            for (String next : arrows.getOrDefault(one, new TreeSet<>())) {
                if (!order.containsKey(next)) {
                    visit(next);
                    earliest.merge(one, earliest.get(next), Math::min);
                } else if (open.contains(next)) {
                    earliest.merge(one, order.get(next), Math::min);
                }
            }
            if (earliest.get(one).equals(order.get(one))) {
                SortedSet<String> circle = new TreeSet<>();
                do {
                    circle.add(open.pop());
                } while (!circle.contains(one));
                if (circle.size() > 1) {
                    found.add(circle);
                }
            }
        }
    }
}
