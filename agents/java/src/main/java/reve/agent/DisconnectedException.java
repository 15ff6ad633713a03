// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;

/** The connection ended; the code is the server's reason, or {@code lost} if there was none. */
public final class DisconnectedException extends AgentException {

    private static final long serialVersionUID = 1L;

    DisconnectedException(String code, String message, Optional<String> hint) {
        super(code, message, hint);
    }
}
