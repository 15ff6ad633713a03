// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

/** A line was refused; the connection goes on. No stack trace: a hostile client can cause many. */
final class BadMessage extends Exception {

    private static final long serialVersionUID = 1L;

    private final transient ServerMessage.Error error;

    BadMessage(long id, String code, String message, String hint) {
        super(message, null, false, false);
        this.error = new ServerMessage.Error(id, code, message, hint);
    }

    ServerMessage.Error error() {
        return error;
    }
}
