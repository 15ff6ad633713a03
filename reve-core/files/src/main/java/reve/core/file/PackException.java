// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import java.io.IOException;

/** Reports a {@link WorldPack} that cannot be made or opened. The message names the pack. */
public final class PackException extends IOException {
    private static final long serialVersionUID = 1L;

    /** Creates an exception with its cause, if any. The message must name the pack. */
    PackException(String message, @Nullable Throwable cause) {
        super(message, cause);
    }

    /** Creates an exception. The message must name the pack. */
    PackException(String message) {
        super(message);
    }
}
