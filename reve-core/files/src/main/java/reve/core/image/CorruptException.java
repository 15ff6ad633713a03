// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

/** Bytes that were read are damaged, or are not of the expected format. */
public final class CorruptException extends RuntimeException {

    private static final long serialVersionUID = 1L;

    /**
     * @param message what is wrong; a caller that knows the file puts its name in front
     */
    public CorruptException(String message) {
        super(message);
    }

    /** Creates an exception with the original cause. */
    public CorruptException(String message, Throwable cause) {
        super(message, cause);
    }
}
