// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.port.Cameras;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.publish.Publisher;
import reve.core.file.AgentPolicy;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.OffHeapArena;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Queries of many clients, with a clock that the test sets. */
class SharedReportsTest {

    private static final long MILLISECOND = 1_000_000;

    private final World world =
            new World("pond", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop = new FrameLoop(world, bus, new Timing(60, 1), Pacing.FAST);
    private final RateLimitedLog log = new RateLimitedLog(1, "reports");
    private final List<String> answers = new ArrayList<>();
    private Publisher publisher;
    private SharedReports reports;
    private int readings;
    private int completions;
    private long nanos;

    /** Time that sending an answer takes [ns]. */
    private long answerNanos;

    @BeforeEach
    void open() {
        var port =
                new WorldPort(
                        "pond",
                        60,
                        new AgentPolicy(List.of(), Optional.empty()),
                        bus,
                        new CommandQueue(16),
                        new SnapshotRing(world, 2),
                        loop,
                        WorldControl.none(),
                        Cameras.none());
        publisher = new Publisher(port, log, () -> {}, () -> {});
        reports =
                new SharedReports(
                        port,
                        publisher,
                        log,
                        Map.of(
                                SharedReports.Kind.STATE,
                                content -> {
                                    completions++;
                                    content.put("clients", completions);
                                    return content;
                                }),
                        () -> nanos);
    }

    private void ask(Requester requester, long id) {
        reports.ask(
                requester,
                new ClientMessage.State(id, false),
                SharedReports.Kind.STATE,
                () -> {
                    readings++;
                    return new HashMap<>(Map.of("reading", readings));
                });
    }

    private void frame() {
        loop.step();
        publisher.tell();
    }

    @Test
    void aFrameReadsAndDescribesOnceForAllAndClientsTakeTurns() {
        List<Requester> clients = List.of(new Asker("a"), new Asker("b"), new Asker("c"));
        for (Requester client : clients) {
            for (int id = 1; id <= 48; id++) {
                ask(client, id);
            }
        }
        frame();
        assertThat(readings).isEqualTo(1);
        assertThat(completions).isEqualTo(1);
        assertThat(answers).hasSize(3 * 48);
        assertThat(answers.subList(0, 4))
                .extracting(line -> line.substring(0, 1))
                .containsExactly("a", "b", "c", "a");
        assertThat(answers.getLast())
                .isEqualTo(
                        "c{\"t\":\"report\",\"id\":48,\"frame\":0,\"of\":\"state\","
                                + "\"content\":{\"reading\":1,\"clients\":1}}\n");
    }

    @Test
    void answersTakeASliceOfTimeAndTheRestWaits() {
        answerNanos = MILLISECOND * 2 / 5;
        var client = new Asker("a");
        for (int id = 1; id <= 7; id++) {
            ask(client, id);
        }
        frame();
        assertThat(answers).hasSize(3);
        frame();
        assertThat(answers).hasSize(6);
        frame();
        assertThat(answers).hasSize(7);
        assertThat(readings).as("one for each frame with answers").isEqualTo(3);
    }

    @Test
    void reportsTakeATenthOfTheTimeInTheLongRun() {
        answerNanos = 10 * MILLISECOND;
        var client = new Asker("a");
        for (int id = 1; id <= 40; id++) {
            ask(client, id);
        }
        for (int frame = 0; frame < 40; frame++) {
            frame();
            reports.proceed();
        }
        assertThat(answers).as("in advance").hasSize(6);
        nanos += 1000 * MILLISECOND;
        for (int frame = 0; frame < 40; frame++) {
            reports.proceed();
            frame();
        }
        assertThat(answers).as("the debt is paid; no time is saved up").hasSize(12);
    }

    /** A client that receives its answers at once. */
    private final class Asker implements Requester {

        private final String name;

        Asker(String name) {
            this.name = name;
        }

        @Override
        public String name() {
            return name;
        }

        @Override
        public boolean controls() {
            return false;
        }

        @Override
        public Encoding encoding() {
            return Encoding.JSON;
        }

        @Override
        public void endRound(ClientMessage.Ready ready) {
            throw new AssertionError("an observer has no rounds");
        }

        @Override
        public void finish(ClientMessage.Request request, ServerMessage result, long frame) {
            throw new AssertionError("a query has no result");
        }

        @Override
        public void refuse(ClientMessage.Request request, String code, String reason) {
            answers.add(name + code);
        }

        @Override
        public boolean answer(ClientMessage.Request request, byte[] line) {
            nanos += answerNanos;
            answers.add(name + new String(line, StandardCharsets.UTF_8));
            return true;
        }
    }
}
