// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

/** A file beside the world file cannot be used; the message, one line, names it and says why. */
public final class AssetException extends Exception {
    private static final long serialVersionUID = 1L;

    /** With a message that names the file. */
    public AssetException(String message) {
        super(message);
    }

    /** With a message that names the file, and what caused it. */
    public AssetException(String message, Throwable cause) {
        super(message, cause);
    }
}
