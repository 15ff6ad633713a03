// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.TestClient;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;

import java.io.IOException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.Callable;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/** The number of messages that the server reads from a client, and the effect of more messages. */
class QuotaTest {

    private static final long SECOND = 1_000_000_000L;
    private static final int RATE = 60;
    private static final Duration FLOOD = Duration.ofMillis(200);

    // ---- counting ----

    private static int taken(Quota quota, int messages, long nanos, long frame) {
        int taken = 0;
        while (taken < messages && quota.hasLeft(nanos, frame)) {
            quota.take();
            taken++;
        }
        return taken;
    }

    @Test
    void fewMayComeAtFirst() {
        assertThat(taken(new Quota(100, RATE, 0, 0), 1000, 0, 0)).isEqualTo(Quota.FIRST);
        assertThat(taken(new Quota(5, RATE, 0, 0), 1000, 0, 0)).isEqualTo(5);
    }

    @Test
    void moreComeWithTimeUpToASecondsWorth() {
        var quota = new Quota(100, RATE, 0, 0);
        taken(quota, 1000, 0, 0);
        assertThat(taken(quota, 1000, SECOND / 4, 0)).isEqualTo(25);
        assertThat(taken(quota, 1000, 10 * SECOND, 0)).isEqualTo(100);
    }

    @Test
    void aWorldThatGoesFasterThanTheClockGivesMore() {
        var quota = new Quota(120, RATE, 0, 0);
        taken(quota, 1000, 0, 0);
        assertThat(taken(quota, 1000, SECOND / 1000, 30)).isEqualTo(60);
        assertThat(taken(quota, 1000, SECOND / 1000, 31)).isEqualTo(2);
    }

    @Test
    void whoKeepsToItNeverWaits() {
        var quota = new Quota(100, RATE, 0, 0);
        for (int i = 1; i <= 10_000; i++) {
            assertThat(taken(quota, 1, i * SECOND / 100, 0)).as("message %d", i).isEqualTo(1);
        }
    }

    // ---- a flood ----

    private static AgentServerConfig config(int messagesPerSecond, Duration flood) {
        AgentServerConfig c = AgentRoom.CONFIG;
        AgentLimits l = c.limits();
        var limits =
                new AgentLimits(
                        l.maxConnections(),
                        l.helloBytes(),
                        l.lineBytes(),
                        messagesPerSecond,
                        l.actsInFlight(),
                        l.outboxMessages(),
                        l.outboxBytes(),
                        l.maxErrors(),
                        l.kept(),
                        l.resumes(),
                        l.hellos());
        AgentTimeouts t = c.timeouts();
        var timeouts =
                new AgentTimeouts(
                        t.hello(),
                        t.line(),
                        t.idle(),
                        flood,
                        t.write(),
                        t.grace(),
                        t.deadline(),
                        t.waiting(),
                        t.linger());
        return new AgentServerConfig(c.address(), limits, timeouts, c.audit(), c.security());
    }

    /** Returns messages, one a line, with the ids 1, 2, … */
    private static String numbered(String message, int count) {
        return IntStream.rangeClosed(1, count)
                .mapToObj(message::formatted)
                .collect(Collectors.joining("\n"));
    }

    @Test
    void whatIsTooMuchWaitsAndNothingIsLost() throws IOException {
        int perSecond = 4000;
        int messages = 6000;
        try (AgentRoom room = new AgentRoom(config(perSecond, Duration.ofMinutes(1)));
                TestClient ada = room.join("ada")) {
            long began = System.nanoTime();
            ada.say(numbered("{'t':'ping','id':%d}", messages));
            for (int i = 1; i <= messages; i++) {
                assertThat(ada.expect("pong").get("id").intValue()).isEqualTo(i);
            }
            // the time if the client still had the quota of one second
            double least = (double) (messages - perSecond) / perSecond;
            assertThat((System.nanoTime() - began) * 1e-9).as("seconds").isGreaterThan(least);
            ada.say("{'t':'bye'}").skipToBye("goodbye");
        }
    }

    @Test
    void whoAlwaysSendsMoreIsCutWhateverItSends() throws IOException {
        for (String message :
                List.of(
                        "{'t':'ping','id':%d}",
                        "{'t':'perceive','every':%d}",
                        "{'t':'act','id':%d,'item':'duck','action':'wind-up'}")) {
            try (AgentRoom room = new AgentRoom(config(300, FLOOD));
                    TestClient ada = room.join("ada")) {
                ada.say(numbered(message, 3000)).skipToBye("too-many-messages");
                assertThat(room.server.stats().cut()).isEqualTo(1);
            }
        }
    }

    @Test
    void whoWaitsForAnswersInBetweenIsNotCut() throws IOException {
        try (AgentRoom room = new AgentRoom(config(3000, Duration.ofSeconds(1)));
                TestClient ada = room.join("ada")) {
            for (long end = System.nanoTime() + 2 * SECOND; System.nanoTime() < end; ) {
                ada.say(numbered("{'t':'ping','id':%d}", 200));
                for (int i = 1; i <= 200; i++) {
                    ada.expect("pong");
                }
            }
            ada.say("{'t':'bye'}").expectBye("goodbye");
        }
    }

    /**
     * A client floods the server for as long as the correct agents need. It reconnects after each
     * disconnect.
     */
    @Test
    void floodsCostTheOthersNoneOfTheirActs() throws Exception {
        int rounds = 200;
        try (AgentRoom room = new AgentRoom(config(300, FLOOD));
                ExecutorService threads = Executors.newVirtualThreadPerTaskExecutor()) {
            var over = new AtomicBoolean();
            List<Future<Integer>> floods = new ArrayList<>();
            List<Future<Integer>> good = new ArrayList<>();
            for (int i = 0; i < 2; i++) {
                String name = "flood" + i;
                floods.add(threads.submit(() -> flood(room, name, over)));
            }
            for (int i = 0; i < 8; i++) {
                String name = "good" + i;
                good.add(threads.submit(agent(room, name, rounds)));
            }
            room.stepUntil("good agents are done", () -> good.stream().allMatch(Future::isDone));
            over.set(true);
            room.stepUntil("floods are over", () -> floods.stream().allMatch(Future::isDone));
            for (Future<Integer> agent : good) {
                assertThat(agent.get()).isEqualTo(rounds);
            }
            for (Future<Integer> flood : floods) {
                assertThat(flood.get()).as("times that it was cut").isPositive();
            }
        }
    }

    /**
     * @return number of disconnects
     */
    private static int flood(AgentRoom room, String name, AtomicBoolean over) throws IOException {
        int cut = 0;
        for (; cut == 0 || !over.get(); cut++) {
            try (TestClient client = room.connect()) {
                client.say("{'t':'hello','protocol':1,'name':'" + name + "-" + cut + "'}")
                        .skipTo("welcome");
                client.say(numbered("{'t':'ping','id':%d}", 3000)).skipToBye("too-many-messages");
            }
        }
        return cut;
    }

    /**
     * @return number of accepted acts
     */
    private static Callable<Integer> agent(AgentRoom room, String name, int rounds) {
        return () -> {
            int accepted = 0;
            try (TestClient client = room.connect()) {
                client.say("{'t':'hello','protocol':1,'name':'" + name + "'}").skipTo("welcome");
                for (int id = 0; id < rounds; id++) {
                    client.say("{'t':'act','id':" + id + ",'item':'duck','action':'wind-up'}");
                    accepted += client.skipTo("result").get("accepted").booleanValue() ? 1 : 0;
                }
            }
            return accepted;
        };
    }
}
