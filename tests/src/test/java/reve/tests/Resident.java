// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.jspecify.annotations.Nullable;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Join;

import java.io.IOException;
import java.util.Map;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;

/** An agent that acts all the time, and keeps its session wherever its world runs. */
final class Resident implements AutoCloseable {
    private static final long BETWEEN_ACTS_NANOSECONDS = 100_000_000;
    private static final long PATIENCE_SECONDS = 60;

    private final String name;
    private final AgentClient client;
    private final Thread thread;
    private volatile int accepted;
    private volatile long lastFrame;
    private volatile boolean ends;
    private volatile @Nullable Exception failure;

    Resident(String host, int port, Join join) throws IOException {
        name = join.name();
        client = AgentClient.connect(host, port, join);
        thread = Thread.ofVirtual().name("resident " + name).start(this::act);
    }

    private void act() {
        try {
            while (!ends) {
                ActResult result = client.act("red", "paint", Map.of("colour", "#00ff00"));
                if (!result.accepted()) {
                    throw new IllegalStateException(name + " was refused: " + result);
                }
                accepted++;
                lastFrame = result.frame().orElseThrow();
                LockSupport.parkNanos(BETWEEN_ACTS_NANOSECONDS);
            }
        } catch (AgentException | IllegalStateException e) {
            failure = e;
        }
    }

    /** Returns the name of its world. */
    String world() {
        return client.welcome().world();
    }

    /** Returns the number of its acts that were accepted. */
    int accepted() {
        return accepted;
    }

    /** Returns the frame of its last accepted act. */
    long lastFrame() {
        return lastFrame;
    }

    /** Waits until two further acts were accepted, of which the last one began after this call. */
    void awaitActs() {
        int before = accepted;
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (accepted < before + 2 && failure == null && System.nanoTime() < end) {
            LockSupport.parkNanos(BETWEEN_ACTS_NANOSECONDS / 10);
        }
        requireSession();
        assertThat(accepted).as("accepted acts of %s", name).isGreaterThanOrEqualTo(before + 2);
    }

    private void requireSession() {
        if (failure != null) {
            throw new AssertionError("the session of " + name + " has ended", failure);
        }
    }

    /** Requires that the agent has the session and the body with which it joined. */
    void requireAtHome() {
        awaitActs();
        assertThat(client.perceive().find(name)).as("the body of %s", name).isPresent();
        assertThat(client.events())
                .as("events of %s", name)
                .noneMatch(
                        event ->
                                event.type().equals("left")
                                        && name.equals(event.fields().get("agent")));
    }

    @Override
    public String toString() {
        return name;
    }

    @Override
    public void close() {
        ends = true;
        thread.interrupt();
        client.close();
    }
}
