// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.lockstep.Allowance;

import java.time.Duration;
import java.util.Optional;

/**
 * How long a server waits for its clients. {@link #PROTOCOL} are the times that PROTOCOL.md
 * promises; tests set shorter ones.
 *
 * @param hello longest wait for the hello
 * @param line longest time from a line's first byte to its last
 * @param idle silence after which a client is pinged, and after as much again cut off
 * @param flood time after which a client is cut that always sends more than is taken
 * @param write longest time that one write may take
 * @param grace longest time that the body of an agent whose connection broke may wait for it
 * @param deadline longest time that an agent in lock-step may have the world wait
 * @param waiting how long agents in lock-step may keep others waiting, beside a tenth of the time
 *     (see {@link Allowance}); without, there is no limit
 * @param linger how long a finished connection may take to go
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
                    Duration.ofSeconds(2),
                    Duration.ofSeconds(10),
                    Duration.ofSeconds(15),
                    Duration.ofSeconds(10),
                    Duration.ofSeconds(5),
                    Duration.ofSeconds(60),
                    Duration.ofSeconds(1),
                    Optional.of(Duration.ofSeconds(10)),
                    Duration.ofSeconds(1));

    /**
     * @throws IllegalArgumentException if one is shorter than a millisecond
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
