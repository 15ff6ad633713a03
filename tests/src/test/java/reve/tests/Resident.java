// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.jspecify.annotations.Nullable;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Join;

import java.io.IOException;
import java.time.Duration;
import java.util.List;
import java.util.Map;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;

/** An agent that acts all the time, and keeps its session wherever its world runs. */
final class Resident implements AutoCloseable {
    /** Usual pause between two acts. */
    static final Duration PAUSE = Duration.ofMillis(100);

    private static final long PATIENCE_SECONDS = 300;
    private static final long POLL_NANOSECONDS = 10_000_000;

    private final String name;
    private final AgentClient client;
    private final Duration pause;
    private final Thread thread;
    private volatile int accepted;
    private volatile long lastFrame;
    private volatile boolean ends;
    private volatile @Nullable Exception failure;

    Resident(String host, int port, Join join, Duration pause) throws IOException {
        name = join.name();
        this.pause = pause;
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
                LockSupport.parkNanos(pause.toNanos());
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

    /**
     * Waits until two further acts of each agent were accepted, of which the last one began after
     * this call.
     */
    static void awaitActs(List<Resident> residents) {
        List<Integer> before = residents.stream().map(Resident::accepted).toList();
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        for (int i = 0; i < residents.size(); i++) {
            residents.get(i).awaitAccepted(before.get(i) + 2, end);
        }
    }

    private void awaitAccepted(int count, long end) {
        while (accepted < count && failure == null && System.nanoTime() < end) {
            LockSupport.parkNanos(POLL_NANOSECONDS);
        }
        requireSession();
        assertThat(accepted).as("accepted acts of %s", name).isGreaterThanOrEqualTo(count);
    }

    private void requireSession() {
        if (failure != null) {
            throw new AssertionError("the session of " + name + " has ended", failure);
        }
    }

    /** Requires that the agents have the sessions and the bodies with which they joined. */
    static void requireAtHome(List<Resident> residents) {
        awaitActs(residents);
        residents.forEach(Resident::requireBody);
    }

    private void requireBody() {
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
