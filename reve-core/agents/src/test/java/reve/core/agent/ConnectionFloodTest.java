// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import ch.qos.logback.classic.Logger;
import ch.qos.logback.classic.spi.ILoggingEvent;
import ch.qos.logback.core.read.ListAppender;

import org.junit.jupiter.api.Test;
import org.slf4j.LoggerFactory;

import reve.core.frame.FramePhase;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.net.SocketException;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Deque;
import java.util.List;
import java.util.Map;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.FutureTask;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;

/**
 * Agents in the world stay, perceive and act while thousands of silent connections arrive per
 * second.
 */
class ConnectionFloodTest {

    /** Seconds of the flood. A long run uses sixty. */
    private static final int SECONDS = Integer.getInteger("reve.abuse.seconds", 2);

    private static final int PER_SECOND = 5_000;

    /** The flood leaves half of its connections open, up to this number. */
    private static final int LEFT_OPEN = 1_000;

    private static final int GOOD = 4;
    private static final long FRAME_NANOS = TimeUnit.SECONDS.toNanos(1) / 60;

    private final Map<Long, Long> madeNanos = new ConcurrentHashMap<>();
    private volatile boolean over;

    @Test
    void whoIsInStaysPerceivesAndActsAndTheLogStaysReadable() throws Exception {
        var log = new ListAppender<ILoggingEvent>();
        log.start();
        var logger = (Logger) LoggerFactory.getLogger("reve.agents");
        logger.addAppender(log);
        try (AgentRoom room = new AgentRoom()) {
            room.bus.subscribe(
                    FramePhase.DERIVE,
                    "clock",
                    event -> madeNanos.put(event.frame(), System.nanoTime()));
            List<FutureTask<List<Long>>> agents = new ArrayList<>();
            for (int i = 0; i < GOOD; i++) {
                TestClient client = room.join("good" + i);
                agents.add(new FutureTask<>(() -> ages(client)));
                Thread.ofPlatform().start(agents.getLast());
            }
            long calm = frames(room, SECONDS);
            int before = log.list.size();
            long begun = System.nanoTime();
            var flood = new FutureTask<>(() -> flood(room.server.address()));
            Thread.ofPlatform().start(flood);
            long flooded = frames(room, SECONDS);
            over = true;
            room.stepUntil(
                    "the flood and the agents are done",
                    () -> flood.isDone() && agents.stream().allMatch(FutureTask::isDone));
            room.stepUntil("only agents are left", () -> room.server.stats().open() <= GOOD);

            List<Long> ages = new ArrayList<>();
            for (FutureTask<List<Long>> agent : agents) {
                ages.addAll(agent.get());
            }
            System.out.printf(
                    "%d connections in %d s; "
                            + "age of perceptions, median and p99 [us]: %s, in the flood %s%n",
                    flood.get(), SECONDS, quantiles(ages, 0, calm), quantiles(ages, calm, flooded));
            assertThat(flood.get()).isPositive();
            long seconds = TimeUnit.NANOSECONDS.toSeconds(System.nanoTime() - begun);
            assertThat((long) log.list.size() - before)
                    .as("lines of the log, one a second and what was left out: %s", log.list)
                    .isLessThanOrEqualTo(2 * (seconds + 5) + GOOD);
        } finally {
            logger.detachAppender(log);
        }
    }

    /**
     * Makes frames at the pace of the clock.
     *
     * @return the last frame
     */
    private static long frames(AgentRoom room, int seconds) {
        long next = System.nanoTime();
        for (int i = 0; i < 60 * seconds; i++) {
            room.step();
            next += FRAME_NANOS;
            LockSupport.parkNanos(next - System.nanoTime());
        }
        return room.loop.frame();
    }

    /**
     * Perceives ever newer frames, and acts, until the flood ends.
     *
     * @return frames and their ages [ns] in turn
     */
    private List<Long> ages(TestClient client) throws IOException {
        List<Long> ages = new ArrayList<>();
        try (client) {
            client.say("{'t':'perceive','every':1}");
            int id = 1;
            for (long last = 0; !over; ) {
                long frame = client.skipTo("perception").get("frame").longValue();
                ages.add(frame);
                ages.add(System.nanoTime() - madeNanos.get(frame));
                assertThat(frame).isGreaterThan(last);
                last = frame;
                client.say("{'t':'act','id':" + id++ + ",'item':'duck','action':'wind-up'}");
            }
            client.say("{'t':'act','id':" + id + ",'item':'duck','action':'wind-up'}");
            JsonNode result = client.skipTo("result");
            while (result.get("id").intValue() != id) {
                assertThat(result.get("accepted").booleanValue()).isTrue();
                result = client.skipTo("result");
            }
        }
        return ages;
    }

    private static String quantiles(List<Long> framesAndAges, long after, long until) {
        long[] ages = new long[framesAndAges.size() / 2];
        int count = 0;
        for (int i = 0; i < framesAndAges.size(); i += 2) {
            if (framesAndAges.get(i) > after && framesAndAges.get(i) <= until) {
                ages[count++] = framesAndAges.get(i + 1);
            }
        }
        Arrays.sort(ages, 0, count);
        return ages[count / 2] / 1000 + " " + ages[count * 99 / 100] / 1000;
    }

    /**
     * @return the number of connections
     */
    private int flood(InetSocketAddress server) throws IOException {
        Deque<Socket> open = new ArrayDeque<>();
        int count = 0;
        try {
            for (long next = System.nanoTime();
                    !over;
                    next += TimeUnit.SECONDS.toNanos(1) / PER_SECOND) {
                LockSupport.parkNanos(next - System.nanoTime());
                open.addLast(knock(server));
                if (count++ % 2 == 0) {
                    open.removeLast().close();
                } else if (open.size() > LEFT_OPEN) {
                    open.removeFirst().close();
                }
            }
        } finally {
            for (Socket socket : open) {
                socket.close();
            }
        }
        return count;
    }

    /** Opens a connection that leaves no state in the operating system when it is closed. */
    private static Socket knock(InetSocketAddress server) throws IOException {
        var socket = new Socket();
        try {
            socket.setSoLinger(true, 0);
            socket.connect(server);
        } catch (SocketException e) {
            socket.close();
            throw e;
        }
        return socket;
    }
}
