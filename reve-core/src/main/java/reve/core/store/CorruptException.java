// SPDX-License-Identifier: Apache-2.0
package reve.core.store;

/** Bytes that were read are not what was written, or something else altogether. */
public final class CorruptException extends RuntimeException {

    private static final long serialVersionUID = 1L;

    /**
     * @param message what is wrong; a caller that knows puts in front of what
     */
    public CorruptException(String message) {
        super(message);
    }

    /** As the other one, with what was found out first. */
    public CorruptException(String message, Throwable cause) {
        super(message, cause);
    }
}
