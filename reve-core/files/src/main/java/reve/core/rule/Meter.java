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
 * Counter of the steps of one evaluation. It ends the evaluation at a limit. It counts operations
 * and not time, so that the number is the same on every machine.
 */
@SuppressWarnings("Immutable") // each object serves one evaluation on one thread
final class Meter implements CelEvaluationListener {
    /** Maximum number of steps of one evaluation. */
    static final int MAX_STEPS = 20_000;

    /** Number of characters that are read, compared or copied for one step. */
    private static final int CHARACTERS_PER_STEP = 32;

    /**
     * Divisor of the cost of a regular expression. A search costs one step for each character of
     * the text and for this number of steps of the pattern.
     */
    private static final int PATTERN_STEPS_PER_STEP = 8;

    /**
     * Number of steps for a part that fails, which costs more time than a result. An evaluation can
     * continue after a failure: {@code 1 / 0 > 1 || true}.
     */
    static final int STEPS_OF_FAILURE = 100;

    private static final int STEPS_OF_FAILURE_PER_DEPTH = 10;

    /** Number of steps for each name if an expression reads all names of an item. */
    private static final int STEPS_PER_NAME = 4;

    private static final int[] NONE = {};
    private static final Exceeded EXCEEDED = new Exceeded();

    private final Cost cost;
    private final int[] haystacks;
    private long left = MAX_STEPS;
    private int next;

    /**
     * Ends an evaluation that takes too many steps. It extends Error instead of Exception, because
     * CEL treats exceptions as values.
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
     * Receives the value of a part of the expression. CEL calls this method after the calls for the
     * operands of the part.
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

    /** Returns the number of steps so far, at most the limit of one evaluation. */
    long steps() {
        return MAX_STEPS - Math.max(0, left);
    }

    /**
     * Counts a step for each value in a list or map, and further steps for the characters of texts.
     * A repeated value counts each time.
     */
    private void weigh(@Nullable Object value) {
        switch (value) {
            case null -> {}
            case String text -> spend(text.length() / CHARACTERS_PER_STEP);
            // This list is not counted here, because a loop is still building it. Its elements are
            // counted when the loop ends.
            case ConcatenatedListView<?> growing -> {}
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
