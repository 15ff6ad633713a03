// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.EnumSource;

import reve.agent.Act;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.DisconnectedException;
import reve.agent.Encoding;
import reve.agent.Join;
import reve.agent.LockStep;
import reve.agent.Perception;
import reve.agent.WorldEvent;
import reve.core.agent.AgentServerConfig;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.SqliteStore;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.LongStream;

/** The Java client over connections that break, with a real server. */
@Tag("slow")
class ReconnectIT {
    private static final Duration GRACE = Duration.ofSeconds(30);
    private static final Duration DEADLINE = Duration.ofSeconds(300);
    private static final int MOST_BYTES = 2_000;
    private static final int ACTS = 100;

    @TempDir private Path folder;
    private final long seed = Long.getLong("reve.test.seed", System.nanoTime());
    private WorldServer server;
    private Thread world;

    @BeforeEach
    void serve() throws Exception {
        System.out.println("seed of the cuts: -Dreve.test.seed=" + seed);
        Path file =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: belfry
                        frame: {rate: 240, steps: 1}
                        agents:
                          body: {physical: {shape: sphere, radius: 0.5}}
                        items:
                          - name: bell
                            access:
                              ring:
                                doc: Once.
                                parameters: {number: {doc: Which one it is.}}
                                effects: [{raise: rang, with: {number: $number}}]
                        """);
        var plan =
                new WorldPlan(
                        WorldFile.load(file),
                        Long.MAX_VALUE,
                        new Persistence(
                                folder,
                                Optional.empty(),
                                Optional.empty(),
                                Optional.empty(),
                                10,
                                SqliteStore.Durability.NORMAL),
                        new Pictures(folder, List.of()));
        server =
                new WorldServer(
                        List.of(plan),
                        Pacing.REAL_TIME,
                        AgentServerConfig.onPort(0)
                                .withDeadline(DEADLINE)
                                .withWaiting(Optional.empty()),
                        Optional.empty(),
                        (type, fields) -> {});
        world = Thread.ofPlatform().start(server::run);
    }

    @AfterEach
    void stop() throws InterruptedException {
        server.stop();
        world.join();
        server.close();
    }

    private static AgentClient join(int port, Join join) throws IOException {
        return Agents.join(port, join);
    }

    private static List<Long> numbers(List<WorldEvent> events) {
        return events.stream()
                .filter(event -> event.type().equals("rang"))
                .map(event -> ((Number) event.fields().get("number")).longValue())
                .toList();
    }

    private static List<Long> all() {
        return LongStream.range(0, ACTS).boxed().toList();
    }

    @ParameterizedTest
    @EnumSource
    void everyActIsDoneOnceAndToldOnceWhereverItsConnectionIsCut(Encoding encoding)
            throws Exception {
        try (Cutter way = new Cutter(server.port(), seed, MOST_BYTES);
                AgentClient eye = join(server.port(), Join.as("eye").withRole("observer"));
                AgentClient ada =
                        join(way.port(), Join.as("ada").withGrace(GRACE).withEncoding(encoding))) {
            ada.perceiveEvery(7);
            var told = new ArrayList<Long>();
            for (int number = 0; number < ACTS; number++) {
                assertThat(ada.act("bell", "ring", Map.of("number", number)).accepted()).isTrue();
                told.addAll(numbers(ada.events()));
            }
            long seen = ada.nextPerception().frame();
            assertThat(ada.nextPerception().frame()).isGreaterThan(seen);
            ada.perceive(); // after the events of the last act
            told.addAll(numbers(ada.events()));
            eye.perceive();
            assertThat(way.cuts()).isPositive();
            assertThat(told).as("%d events missed", ada.missedEvents()).isEqualTo(all());
            assertThat(numbers(eye.events())).isEqualTo(all());
        }
    }

    @Test
    void anAgentInLockStepGoesOnWhereverItsConnectionIsCut() throws Exception {
        try (Cutter way = new Cutter(server.port(), seed, MOST_BYTES);
                AgentClient ada =
                        join(
                                way.port(),
                                Join.as("ada")
                                        .withGrace(GRACE)
                                        .withLockStep(LockStep.every(1).withDeadline(DEADLINE)))) {
            var told = new ArrayList<Long>();
            long frame = ada.observe().frame();
            for (int number = 0; number < ACTS; number++) {
                Perception next = ada.step(Act.of("bell", "ring", Map.of("number", number)));
                assertThat(next.frame()).isGreaterThan(frame);
                assertThat(next.results().getFirst().accepted()).isTrue();
                frame = next.frame();
                told.addAll(numbers(ada.events()));
            }
            ada.step();
            told.addAll(numbers(ada.events()));
            assertThat(way.cuts()).isPositive();
            assertThat(told).isEqualTo(all());
        }
    }

    @Test
    void whoHasNoGraceIsToldThatTheConnectionBroke() throws Exception {
        try (Cutter way = new Cutter(server.port(), seed, 0);
                AgentClient ada = join(way.port(), Join.as("ada"))) {
            way.cut();
            assertThatExceptionOfType(DisconnectedException.class)
                    .isThrownBy(ada::perceive)
                    .extracting(AgentException::code)
                    .isEqualTo("lost");
        }
    }

    @Test
    void whoCannotComeBackInTimeIsToldThatTheConnectionBroke() throws Exception {
        try (Cutter way = new Cutter(server.port(), seed, 0);
                AgentClient ada =
                        join(way.port(), Join.as("ada").withGrace(Duration.ofMillis(300)))) {
            way.block();
            assertThatExceptionOfType(DisconnectedException.class)
                    .isThrownBy(ada::perceive)
                    .extracting(AgentException::code)
                    .isEqualTo("lost");
        }
    }

    @Test
    void whoIsClosedWhileItTriesToComeBackEnds() throws Exception {
        AgentClient ada;
        try (Cutter way = new Cutter(server.port(), seed, 0)) {
            ada = join(way.port(), Join.as("ada").withGrace(GRACE));
            way.block();
            ada.close();
        }
        assertThatExceptionOfType(DisconnectedException.class)
                .isThrownBy(ada::perceive)
                .extracting(AgentException::code)
                .isEqualTo("closed");
    }
}
