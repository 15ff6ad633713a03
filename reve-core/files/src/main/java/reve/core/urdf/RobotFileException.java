// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

/**
 * Reports a robot model that cannot be imported. The message is one line. It names the file and the
 * line, and what was expected.
 */
public final class RobotFileException extends Exception {
    private static final long serialVersionUID = 1L;

    /** Creates an exception. The message must name the position in the file. */
    public RobotFileException(String message) {
        super(message);
    }
}
