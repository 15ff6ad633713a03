// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

/** An expression cannot be understood; the message says why. */
public final class ExpressionException extends Exception {
    private static final long serialVersionUID = 1L;

    /** Characters before the mistake. */
    private final int offset;

    ExpressionException(int offset, String message) {
        super(message);
        this.offset = offset;
    }

    /** Where in the text, in characters from its beginning. */
    public int offset() {
        return offset;
    }
}
