// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.frame.TimeBudget;
import reve.core.unit.Unit;

import java.util.Optional;

/**
 * Reader of the budget of a law: either a time such as {@code 2 ms}, or a mapping with a time and a
 * response.
 */
final class BudgetReader {
    private static final Unit SECOND = Unit.parse("s");

    private final Quantities quantities;
    private final Problems problems;

    BudgetReader(Quantities quantities, Problems problems) {
        this.quantities = quantities;
        this.problems = problems;
    }

    /** Returns the budget. Records a problem and returns empty if it is wrong. */
    Optional<TimeBudget> read(Node node) {
        Optional<Node> time = node.isMapping() ? node.get("time") : Optional.of(node);
        return time.flatMap(given -> quantities.number(given, SECOND))
                .filter(seconds -> isPossible(time.get(), seconds))
                .map(
                        seconds ->
                                TimeBudget.of(
                                        seconds,
                                        number(
                                                node,
                                                "frames",
                                                TimeBudget.DEFAULT_FRAMES,
                                                1,
                                                TimeBudget.MOST_FRAMES),
                                        response(node),
                                        number(
                                                node,
                                                "every",
                                                TimeBudget.DEFAULT_EVERY,
                                                2,
                                                TimeBudget.MOST_EVERY)));
    }

    private boolean isPossible(Node node, double seconds) {
        boolean possible = seconds > 0 && seconds <= TimeBudget.MOST_SECONDS;
        if (!possible) {
            problems.add(
                    node,
                    node.label()
                            + ": found "
                            + seconds
                            + " s, expected a time above 0 s, and at most "
                            + (int) TimeBudget.MOST_SECONDS
                            + " s");
        }
        return possible;
    }

    /**
     * Returns the number under a key, or {@code otherwise} if there is no valid one. The schema
     * check has already reported a number outside of the range.
     */
    private static int number(Node node, String key, int otherwise, int least, int most) {
        return Optional.of(node)
                .filter(Node::isMapping)
                .flatMap(mapping -> mapping.get(key))
                .flatMap(Node::number)
                .map(found -> (int) Math.clamp(found, least, most))
                .orElse(otherwise);
    }

    private static TimeBudget.Response response(Node node) {
        return Optional.of(node)
                .filter(Node::isMapping)
                .flatMap(mapping -> mapping.get("then"))
                .flatMap(Node::text)
                .flatMap(TimeBudget.Response::find)
                .orElse(TimeBudget.Response.WARN);
    }
}
