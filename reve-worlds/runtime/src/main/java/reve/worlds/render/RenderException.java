// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

/** A failure to make a picture. The message gives the reason and says what to do. */
public final class RenderException extends RuntimeException {
    private static final long serialVersionUID = 1L;

    /** Creates an exception with a message that says what the renderer lacks or refused. */
    public RenderException(String message) {
        super(message);
    }

    /**
     * Creates an exception with a message that says what the renderer lacks or refused, and its
     * cause.
     */
    public RenderException(String message, Throwable cause) {
        super(message, cause);
    }
}
