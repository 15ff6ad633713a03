// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

/** An expression gave no value this time; the message quotes it and says why. */
public final class EvaluationException extends Exception {
    private static final long serialVersionUID = 1L;

    EvaluationException(String message) {
        super(message);
    }
}
