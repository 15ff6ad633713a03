package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.Callable;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.atomic.AtomicBoolean;
import org.junit.jupiter.api.Test;
import tools.jackson.databind.JsonNode;

/** How many messages a client may send, and what becomes of one that sends more. */
class QuotaTest {

    private static final long SECOND = 1_000_000_000L;
    private static final int RATE = 60;
    private static final int PER_SECOND = 300;

    // ---- counting ----

    private static int taken(Quota quota, int messages, long nanos, long frame) {
        int taken = 0;
        for (int i = 0; i < messages; i++) {
            taken += quota.take(nanos, frame) ? 1 : 0;
        }
        return taken;
    }

    @Test
    void asManyAsInASecondMayComeAtOnceAndNoMore() {
        assertThat(taken(new Quota(100, RATE, 0, 0), 1000, 0, 0)).isEqualTo(100);
    }

    @Test
    void theyComeBackWithTimeUpToASecondsWorth() {
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
    void whoKeepsToItIsNeverRefused() {
        var quota = new Quota(100, RATE, 0, 0);
        for (int i = 1; i <= 10_000; i++) {
            assertThat(quota.take(i * SECOND / 100, 0)).as("message %d", i).isTrue();
        }
    }

    // ---- a flood ----

    private static AgentServerConfig config() {
        AgentServerConfig c = AgentRoom.CONFIG;
        AgentLimits l = c.limits();
        var limits = new AgentLimits(l.maxConnections(), l.helloBytes(), l.lineBytes(), PER_SECOND, l.actsInFlight(),
                l.outboxMessages(), l.outboxBytes(), l.maxErrors());
        return new AgentServerConfig(c.address(), limits, c.timeouts(), c.audit(), c.security());
    }

    @Test
    void whoSendsMoreIsRefusedThenCutWhateverItSends() throws IOException {
        for (String message : List.of("{'t':'ping','id':%d}", "{'t':'perceive','every':%d}",
                "{'t':'act','id':%d,'item':'duck','action':'wind-up'}", "{'t':'look','id':%d,'sensor':'eye'}")) {
            try (AgentRoom room = new AgentRoom(config()); TestClient ada = room.join("ada")) {
                var flood = new StringBuilder();
                for (int i = 1; i <= 3 * PER_SECOND; i++) {
                    flood.append(message.formatted(i)).append('\n');
                }
                ada.say(flood.toString());
                JsonNode answer = ada.next();
                for (; !answer.get("t").stringValue().equals("bye"); answer = ada.next()) {
                    if (answer.get("t").stringValue().equals("error")) {
                        assertThat(answer.get("code").stringValue()).isIn("too-many-messages", "no-such-camera");
                    }
                }
                assertThat(answer.get("code").stringValue()).as(message).isEqualTo("too-many-errors");
                assertThat(room.server.stats().cut()).isEqualTo(1);
            }
        }
    }

    @Test
    void whoSendsMoreMayStillSayBye() throws IOException {
        try (AgentRoom room = new AgentRoom(config()); TestClient ada = room.join("ada")) {
            ada.say(("{'t':'ping','id':1}\n").repeat(PER_SECOND + 2)).say("{'t':'bye'}").skipToBye("goodbye");
        }
    }

    /** Floods for as long as the good agents need, each by a client that is cut and comes again. */
    @Test
    void floodsCostTheOthersNoneOfTheirActs() throws Exception {
        int rounds = 200;
        try (AgentRoom room = new AgentRoom(config());
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
     * Says bye at the end: where nobody acts any more, frames follow each other so fast that no flood is too much.
     *
     * @return how often it was cut
     */
    private static int flood(AgentRoom room, String name, AtomicBoolean over) throws IOException {
        String pings = "{'t':'ping','id':1}\n".repeat(30 * PER_SECOND);
        int cut = 0;
        for (int i = 0; !over.get(); i++) {
            try (TestClient client = room.connect()) {
                client.say("{'t':'hello','protocol':1,'name':'" + name + "-" + i + "'}").skipTo("welcome");
                String code = client.say(pings).say("{'t':'bye'}").skipTo("bye").get("code").stringValue();
                assertThat(code).isIn("too-many-errors", "goodbye");
                cut += code.equals("too-many-errors") ? 1 : 0;
            } catch (IOException reset) {
                cut++; // while it still wrote
            }
        }
        return cut;
    }

    /** @return how many of its acts were accepted */
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
