// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import java.time.Instant;

/**
 * A record of the audit log, as clients may read it.
 *
 * @param number number of the record among those of its world since the server started, from 1
 * @param at time at which the message was written to the connection
 * @param client name of the client that the message was sent to
 * @param type type of the message in the protocol; empty if it is unknown
 * @param message the beginning of the message as JSON, as the file contains it
 * @param length length of the whole message as JSON [characters]
 */
public record AuditRecord(
        long number, Instant at, String client, String type, String message, int length) {

    /** Returns whether {@link #message} lacks the end of the message. */
    public boolean isCut() {
        return length > RecentRecords.MOST_CHARACTERS;
    }
}
