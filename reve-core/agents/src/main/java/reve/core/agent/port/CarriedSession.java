// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import java.util.List;
import java.util.Optional;
import java.util.OptionalLong;

/**
 * The session of a client that one server had and another one continues, with the world of the
 * session.
 *
 * @param client name of the client
 * @param body id of the client's body; empty if it has none
 * @param state what the session needs, as a JSON object. It contains no secret, only the hash of
 *     the session's token
 * @param since changes of the session after the state was written; empty if the server ended the
 *     session in an orderly manner, so that the state is complete
 */
public record CarriedSession(
        String client, OptionalLong body, String state, Optional<Since> since) {

    /**
     * The changes of a session of a lost server. The events for the client are not among them.
     *
     * @param finished commands that were finished, oldest first
     * @param forgottenId highest id of a finished command that is missing in the list; -1 if none
     */
    public record Since(List<FinishedCommand> finished, long forgottenId) {
        /** Copies the list. */
        public Since {
            finished = List.copyOf(finished);
        }
    }

    /** Creates a session whose state is complete. */
    public CarriedSession(String client, OptionalLong body, String state) {
        this(client, body, state, Optional.empty());
    }
}
