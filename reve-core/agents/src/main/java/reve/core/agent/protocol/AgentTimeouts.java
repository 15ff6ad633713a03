// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.lockstep.Allowance;

import java.time.Duration;
import java.util.Optional;

/**
 * Time limits of a server. {@link #PROTOCOL} has the times that PROTOCOL.md states; tests use
 * shorter times.
 *
 * @param hello maximum time until the hello
 * @param line maximum time from the first byte of a message to the last
 * @param idle time without a message after which the server sends a ping to a client. If the client
 *     sends nothing for the same time again, the server disconnects it
 * @param flood time after which a client that exceeds its quota without a pause is disconnected
 * @param write maximum time of one write
 * @param grace maximum time that the body of a disconnected agent stays for a new connection
 * @param deadline maximum time that the world waits for an agent in lock-step
 * @param waiting time by which agents in lock-step may delay others, in addition to a tenth of the
 *     elapsed time (see {@link Allowance}); if empty, there is no limit
 * @param linger maximum time until a finished connection is closed
 */
public record AgentTimeouts(
        Duration hello,
        Duration line,
        Duration idle,
        Duration flood,
        Duration write,
        Duration grace,
        Duration deadline,
        Optional<Duration> waiting,
        Duration linger) {

    public static final AgentTimeouts PROTOCOL =
            new AgentTimeouts(
                    Duration.ofSeconds(5), // includes TLS, which takes seconds in a new JVM
                    Duration.ofSeconds(10),
                    Duration.ofSeconds(15),
                    Duration.ofSeconds(10),
                    Duration.ofSeconds(5),
                    Duration.ofSeconds(60),
                    Duration.ofSeconds(1),
                    Optional.of(Duration.ofSeconds(10)),
                    Duration.ofSeconds(1));

    /**
     * Checks the times.
     *
     * @throws IllegalArgumentException if a time is shorter than a millisecond
     */
    public AgentTimeouts {
        requirePositive("hello", hello);
        requirePositive("line", line);
        requirePositive("idle", idle);
        requirePositive("flood", flood);
        requirePositive("write", write);
        requirePositive("grace", grace);
        requirePositive("deadline", deadline);
        waiting.ifPresent(time -> requirePositive("waiting", time));
        requirePositive("linger", linger);
    }

    private static void requirePositive(String name, Duration time) {
        if (time.toMillis() <= 0) {
            throw new IllegalArgumentException(
                    "timeout " + name + " is " + time.toMillis() + " ms, expected more than 0");
        }
    }
}
