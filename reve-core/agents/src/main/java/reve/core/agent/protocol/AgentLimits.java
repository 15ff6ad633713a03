// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.session.Quota;
import reve.core.agent.session.Resumes;

/**
 * How much a server takes from its clients, and keeps for them. {@link #PROTOCOL} are those that
 * PROTOCOL.md promises; tests set smaller ones.
 *
 * @param maxConnections open connections, whether welcomed or not; and clients, whether connected
 *     or not
 * @param helloBytes most bytes before the hello is complete
 * @param lineBytes longest line from a client
 * @param messagesPerSecond most messages from one client, see {@link Quota}
 * @param actsInFlight most acts and other commands of one client that wait for their result
 * @param outboxMessages most messages of one agent that wait to be written
 * @param outboxBytes and most bytes of them
 * @param maxErrors refused messages after which a connection ends
 * @param kept most sessions without a token that wait for their client to come back
 * @param resumes most resumes of one session at once; then {@value Resumes#PER_SECOND} a second
 */
public record AgentLimits(
        int maxConnections,
        int helloBytes,
        int lineBytes,
        int messagesPerSecond,
        int actsInFlight,
        int outboxMessages,
        int outboxBytes,
        int maxErrors,
        int kept,
        int resumes) {

    public static final AgentLimits PROTOCOL =
            new AgentLimits(4096, 8 * 1024, 64 * 1024, 4096, 64, 1024, 1024 * 1024, 8, 16, 8);

    /**
     * @throws IllegalArgumentException if one is not positive
     */
    public AgentLimits {
        requirePositive("maxConnections", maxConnections);
        requirePositive("helloBytes", helloBytes);
        requirePositive("lineBytes", lineBytes);
        requirePositive("messagesPerSecond", messagesPerSecond);
        requirePositive("actsInFlight", actsInFlight);
        requirePositive("outboxMessages", outboxMessages);
        requirePositive("outboxBytes", outboxBytes);
        requirePositive("maxErrors", maxErrors);
        requirePositive("kept", kept);
        requirePositive("resumes", resumes);
    }

    private static void requirePositive(String name, int value) {
        if (value <= 0) {
            throw new IllegalArgumentException(
                    "limit " + name + " is " + value + ", expected more than 0");
        }
    }
}
