// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

/** A line was refused; the connection goes on. No stack trace: a hostile client can cause many. */
public final class BadMessage extends Exception {

    private static final long serialVersionUID = 1L;

    private final transient ServerMessage.Error error;

    /** A message that is refused with an error. */
    public BadMessage(long id, String code, String message, String hint) {
        super(message, null, false, false);
        this.error = new ServerMessage.Error(id, code, message, hint);
    }

    /** Returns what the client is sent. */
    public ServerMessage.Error error() {
        return error;
    }
}
