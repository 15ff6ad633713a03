// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import dev.cel.common.ast.CelExpr;
import dev.cel.runtime.CelEvaluationListener;
import dev.cel.runtime.ConcatenatedListView;

import org.jspecify.annotations.Nullable;

import reve.core.rule.Cost.Part;

import java.util.List;
import java.util.Map;

/**
 * Counter of the steps of one evaluation, which ends the evaluation at a limit. Counts operations
 * and no time, so that the number is the same on every machine.
 */
@SuppressWarnings("Immutable") // used by one evaluation on one thread
final class Meter implements CelEvaluationListener {
    /** Maximum steps of one evaluation; a step takes about 0.1 microseconds. */
    static final int MAX_STEPS = 20_000;

    /** Number of characters whose reading, comparing or copying counts as one step. */
    private static final int CHARACTERS_PER_STEP = 32;

    /**
     * Number of steps of a regular expression, per character of the text, that count as one step.
     */
    private static final int PATTERN_STEPS_PER_STEP = 8;

    /**
     * Steps for a part that fails, which costs more than a result. An evaluation can continue after
     * it: {@code 1 / 0 > 1 || true}.
     */
    private static final int STEPS_OF_FAILURE = 100;

    private static final int STEPS_OF_FAILURE_PER_DEPTH = 10;

    /** Steps for each name when all names of an item are read. */
    private static final int STEPS_PER_NAME = 4;

    private static final int[] NONE = {};
    private static final Exceeded EXCEEDED = new Exceeded();

    private final Cost cost;
    private final int[] haystacks;
    private long left = MAX_STEPS;
    private int next;

    /**
     * Ends an evaluation that takes too many steps. Not an Exception, because CEL treats exceptions
     * as values.
     */
    static final class Exceeded extends Error {
        private static final long serialVersionUID = 1L;

        private Exceeded() {
            super("too many steps", null, false, false);
        }
    }

    Meter(Cost cost) {
        this.cost = cost;
        haystacks = cost.haystacks() == 0 ? NONE : new int[cost.haystacks()];
    }

    /**
     * Called by CEL with the value of a part of the expression, after the calls for its operands.
     */
    @Override
    public void callback(CelExpr expr, Object value) {
        Part part = cost.part(expr.id());
        if (next != 0 && next != expr.id()) {
            fail(cost.part(next).depth());
        }
        next = part.next();
        spend(1);
        switch (part.role()) {
            case PICKED -> {}
            case TRUTH -> {
                if (!(value instanceof Boolean)) {
                    fail(part.depth());
                }
            }
            case MEMBERS -> {
                if (!(value instanceof Map)) {
                    weigh(value);
                }
            }
            case RANGE -> {
                weigh(value);
                if (!(value instanceof List || value instanceof Map)) {
                    fail(part.depth());
                }
            }
            case MATCHED -> {
                weigh(value);
                if (value instanceof String text) {
                    spend(
                            part.detail()
                                    + (long) text.length()
                                            * part.detail()
                                            / PATTERN_STEPS_PER_STEP);
                }
            }
            case HAYSTACK -> {
                weigh(value);
                haystacks[part.detail()] = value instanceof String text ? text.length() : 0;
            }
            case NEEDLE -> {
                weigh(value);
                if (value instanceof String text) {
                    spend((long) haystacks[part.detail()] * text.length() / CHARACTERS_PER_STEP);
                }
            }
            case READ -> weigh(value);
        }
    }

    private void fail(int depth) {
        spend(STEPS_OF_FAILURE + STEPS_OF_FAILURE_PER_DEPTH * depth);
    }

    /** Returns the steps so far, at most the limit of one evaluation. */
    long steps() {
        return MAX_STEPS - Math.max(0, left);
    }

    /**
     * Counts a step for each value inside, and for characters of texts. A repeated value counts
     * each time.
     */
    private void weigh(@Nullable Object value) {
        switch (value) {
            case null -> {}
            case String text -> spend(text.length() / CHARACTERS_PER_STEP);
            case ConcatenatedListView<?>
                            growing -> {} // a list that a loop is building: counted when the loop
            // ends
            case List<?> list -> {
                for (Object element : list) {
                    spend(1);
                    weigh(element);
                }
            }
            case ItemNames.View view -> spend(STEPS_PER_NAME * view.size());
            case Map<?, ?> map -> {
                for (Map.Entry<?, ?> entry : map.entrySet()) {
                    spend(1);
                    weigh(entry.getKey());
                    weigh(entry.getValue());
                }
            }
            default -> {}
        }
    }

    private void spend(long steps) {
        left -= steps;
        if (left < 0) {
            throw EXCEEDED;
        }
    }
}
