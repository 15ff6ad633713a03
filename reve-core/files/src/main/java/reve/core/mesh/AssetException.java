// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

/**
 * Reports a mesh, image or other file of the world's folder that cannot be used. The message is one
 * line that names the file and the reason.
 */
public final class AssetException extends Exception {
    private static final long serialVersionUID = 1L;

    /** Creates an exception. The message must name the file. */
    public AssetException(String message) {
        super(message);
    }

    /** Creates an exception with its cause. The message must name the file. */
    public AssetException(String message, Throwable cause) {
        super(message, cause);
    }
}
