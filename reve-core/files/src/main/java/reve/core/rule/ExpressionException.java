// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

/** Reports that the text of an expression is invalid. The message gives the reason. */
public final class ExpressionException extends Exception {
    private static final long serialVersionUID = 1L;

    /** Position of the error: number of characters before it. */
    private final int offset;

    ExpressionException(int offset, String message) {
        super(message);
        this.offset = offset;
    }

    /** Returns the position of the error in the text, in characters from its beginning. */
    public int offset() {
        return offset;
    }
}
