// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

/** A picture could not be made. The message says why and what to do. */
public final class RenderException extends RuntimeException {
    private static final long serialVersionUID = 1L;

    public RenderException(String message) {
        super(message);
    }

    public RenderException(String message, Throwable cause) {
        super(message, cause);
    }
}
