// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.session.Quota;
import reve.core.agent.session.Resumes;

/**
 * Limits on clients' messages, and on the data that the server stores for clients. {@link
 * #PROTOCOL} has the limits that PROTOCOL.md states; tests use smaller limits.
 *
 * @param maxConnections maximum number of open connections, and of clients, connected or not
 * @param helloBytes maximum number of bytes until the hello is complete
 * @param lineBytes maximum length of a message from a client [bytes]
 * @param messagesPerSecond maximum rate of messages from one client, see {@link Quota}
 * @param actsInFlight maximum number of commands of one client that have no result yet
 * @param outboxMessages maximum number of messages of one agent that wait to be written
 * @param outboxBytes maximum total size of these messages [bytes]
 * @param maxErrors number of refused messages after which a connection ends
 * @param kept maximum number of sessions without a token that wait for a new connection
 * @param resumes maximum number of resumes of one session in a burst; after the burst, one session
 *     may resume {@value Resumes#PER_SECOND} times per second
 * @param hellos maximum number of clients that may join at once; after such a burst, 100 clients
 *     per second may join, and the others wait
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
        int resumes,
        int hellos) {

    public static final AgentLimits PROTOCOL =
            new AgentLimits(4096, 8 * 1024, 64 * 1024, 4096, 64, 1024, 1024 * 1024, 8, 16, 8, 256);

    /**
     * Checks the limits.
     *
     * @throws IllegalArgumentException if a limit is not positive
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
        requirePositive("hellos", hellos);
    }

    private static void requirePositive(String name, int value) {
        if (value <= 0) {
            throw new IllegalArgumentException(
                    "limit " + name + " is " + value + ", expected more than 0");
        }
    }
}
