// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

/**
 * Reports that a message of a client was refused. The connection continues. The exception has no
 * stack trace, because stack traces are expensive and a hostile client can cause many exceptions.
 */
public final class BadMessage extends Exception {

    private static final long serialVersionUID = 1L;

    private final transient ServerMessage.Error error;

    /** Creates the error reply for a message. */
    public BadMessage(long id, String code, String message, String hint) {
        super(message, null, false, false);
        this.error = new ServerMessage.Error(id, code, message, hint);
    }

    /** Returns the error message for the client. */
    public ServerMessage.Error error() {
        return error;
    }
}
