// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

/** Reports that stored bytes are damaged or do not have the expected format. */
public final class CorruptException extends RuntimeException {

    private static final long serialVersionUID = 1L;

    /**
     * Creates an exception.
     *
     * @param message the error; a caller that knows the file prepends the name of the file
     */
    public CorruptException(String message) {
        super(message);
    }

    /** Creates an exception with the original cause. */
    public CorruptException(String message, Throwable cause) {
        super(message, cause);
    }
}
