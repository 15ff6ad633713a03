// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

/**
 * Reports that an action was refused. The world is unchanged. The code is for programs and never
 * changes its meaning. The message is for people.
 */
public final class ActionRefused extends Exception {
    private static final long serialVersionUID = 1L;

    /** The code of the reason, for programs. */
    private final String code;

    /** Creates a refusal with a code of the protocol and a message for people. */
    public ActionRefused(String code, String message) {
        this(code, message, null);
    }

    /**
     * @param cause the error inside the action, for the log
     */
    public ActionRefused(String code, String message, @Nullable Throwable cause) {
        super(message, cause);
        this.code = code;
    }

    /** Returns a short lower-case code of the reason, for example {@code missing-argument}. */
    public String code() {
        return code;
    }
}
