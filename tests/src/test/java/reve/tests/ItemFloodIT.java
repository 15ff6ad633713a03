// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.Perception;
import reve.core.file.AgentPolicy;
import reve.core.frame.Pacing;
import reve.worlds.journal.RunLog;
import reve.worlds.server.Replay;
import reve.worlds.server.Simulation;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.net.InetAddress;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicLong;

/** One agent creates as many items as it can in the workshop that ships with the project. */
@Tag("slow")
class ItemFloodIT {
    private static final String WORLD = Project.WORLDS.resolve("workshop").toString();

    /** Frames in which both agents are watched when the quota is full. */
    private static final int FRAMES = 120;

    private static final int EVERY = 4;

    @TempDir private Path folder;

    private Server serve(Path store, String... more) throws IOException {
        String[] arguments = new String[8 + more.length];
        System.arraycopy(
                new String[] {
                    "serve", WORLD, "--port", "0", "--json", "--quiet", "--store", store.toString()
                },
                0,
                arguments,
                0,
                8);
        System.arraycopy(more, 0, arguments, 8, more.length);
        return Server.start(folder, arguments);
    }

    @Test
    void whoCreatesItemsWithoutEndStopsAtItsQuotaAndTheOthersNoticeNothing() throws Exception {
        Path store = folder.resolve("world.db");
        Path log = folder.resolve("run.log");
        try (Server server = serve(store, "--record", log.toString());
                Flood flood = new Flood(Integer.parseInt(server.port()));
                AgentClient innocent = join(server, "innocent")) {
            flood.untilRefused();
            innocent.perceiveEvery(EVERY);
            Perception first = innocent.nextPerception();
            Perception last = first;
            while (last.frame() < first.frame() + FRAMES) {
                flood.strike();
                last = innocent.nextPerception();
            }
            assertThat(
                            last.items().stream()
                                    .filter(item -> item.name().startsWith("spark-"))
                                    .count())
                    .isEqualTo(AgentPolicy.DEFAULT_ITEMS);
            assertThat(flood.refusal).contains("too-many-items");
        } // killed
        assertThat(madeAgain(log)).as("counted in a replay").isEqualTo(AgentPolicy.DEFAULT_ITEMS);

        try (Server server = serve(store);
                AgentClient evil = join(server, "evil")) {
            assertThat(evil.welcome().limits().items()).hasValue(AgentPolicy.DEFAULT_ITEMS);
            ActResult strike = evil.act("iron", "strike", Map.of("strength", 0));
            assertThat(strike.code()).as("counted in a store").contains("too-many-items");
        }
    }

    private static AgentClient join(Server server, String name) throws IOException {
        return Agents.join(Integer.parseInt(server.port()), name);
    }

    private static int madeAgain(Path log) throws IOException {
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // the list stays open for further records
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.world().made()).isEqualTo(again.world().made("evil"));
                return again.world().made("evil");
            }
        }
    }

    /** An agent that strikes the hot iron, two sparks at a time, as often as the server permits. */
    private static final class Flood implements AutoCloseable {
        private static final int IN_FLIGHT = 60;

        private final Socket socket;
        private final BufferedReader in;
        private final AtomicLong id = new AtomicLong();
        private String refusal = "";

        Flood(int port) throws IOException {
            socket = new Socket(InetAddress.getLoopbackAddress(), port);
            in =
                    new BufferedReader(
                            new InputStreamReader(socket.getInputStream(), StandardCharsets.UTF_8));
            say("{\"t\":\"hello\",\"protocol\":1,\"name\":\"evil\"}\n");
            for (int i = 0; i < 2; i++) {
                say(
                        "{\"t\":\"act\",\"id\":"
                                + id.incrementAndGet()
                                + ",\"item\":\"bellows\",\"action\":\"pump\",\"arguments\":{\"what\":\"iron\",\"by\":450}}\n");
                result();
            }
        }

        void untilRefused() throws IOException {
            for (int i = 0; i < 100 && refusal.isEmpty(); i++) {
                strike();
            }
            assertThat(refusal).as("of %d strikes", id.get()).isNotEmpty();
        }

        /** Sends as many acts at once as may wait for their results. */
        void strike() throws IOException {
            var acts = new StringBuilder();
            for (int i = 0; i < IN_FLIGHT; i++) {
                acts.append("{\"t\":\"act\",\"id\":")
                        .append(id.incrementAndGet())
                        .append(",\"item\":\"iron\",\"action\":\"strike\",")
                        .append("\"arguments\":{\"strength\":0}}\n");
            }
            say(acts.toString());
            for (int i = 0; i < IN_FLIGHT; i++) {
                String result = result();
                if (result.contains("\"accepted\":false")) {
                    refusal = result;
                }
            }
        }

        private void say(String lines) throws IOException {
            socket.getOutputStream().write(lines.getBytes(StandardCharsets.UTF_8));
        }

        private String result() throws IOException {
            String line = in.readLine();
            while (!line.contains("\"t\":\"result\"")) {
                line = in.readLine();
            }
            return line;
        }

        @Override
        public void close() throws IOException {
            socket.close();
        }
    }
}
