// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

/**
 * A change of the sessions of a world. The notes of all frames tell another server which sessions
 * it can continue if this server is lost.
 */
public sealed interface SessionNote {

    /** Returns the name of the client. */
    String client();

    /** Reports that a session began, or continues with another body. Replaces all earlier notes. */
    record Began(CarriedSession session) implements SessionNote {
        @Override
        public String client() {
            return session.client();
        }
    }

    /** Reports that a command of a client was executed or refused by the world. */
    record Finished(String client, FinishedCommand command) implements SessionNote {}

    /** Reports that a session has ended and cannot be resumed. */
    record Ended(String client) implements SessionNote {}
}
