// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

/**
 * An action was refused; the world is as it was before. The code is for programs and never changes
 * its meaning, the message is for people.
 */
public final class ActionRefused extends Exception {
    private static final long serialVersionUID = 1L;

    /** What clients recognise the reason by. */
    private final String code;

    /** With the code of the protocol and a message for people. */
    public ActionRefused(String code, String message) {
        this(code, message, null);
    }

    /**
     * @param cause what went wrong in the action itself, for the log
     */
    public ActionRefused(String code, String message, @Nullable Throwable cause) {
        super(message, cause);
        this.code = code;
    }

    /** A short lower-case name of the reason, such as {@code missing-argument}. */
    public String code() {
        return code;
    }
}
