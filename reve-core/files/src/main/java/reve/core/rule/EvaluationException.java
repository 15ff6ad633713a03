// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

/**
 * Reports that the evaluation of an expression failed. The message quotes the expression and gives
 * the reason.
 */
public final class EvaluationException extends Exception {
    private static final long serialVersionUID = 1L;

    EvaluationException(String message) {
        super(message);
    }

    EvaluationException(Throwable cause) {
        super(cause);
    }
}
