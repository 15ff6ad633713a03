// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.jspecify.annotations.Nullable;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.concurrent.TimeUnit;
import java.util.stream.Stream;

/** Servers whose laws harm the process that they run in (reve-pe-adapter/src/test/native). */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class EngineProcessIT {
    @TempDir private Path folder;

    private StoneWorld world;

    @BeforeEach
    void makeWorld() throws Exception {
        world = StoneWorld.in(folder);
    }

    /**
     * Puts a complete test law into the laws folder. First copies it to a file beside the folder,
     * and then renames this file.
     */
    private Path drop(String law) throws Exception {
        String file = "libvesper_law_hostile_" + law + ".so";
        Path copy =
                Files.copy(
                        Project.NATIVE.resolve("adapter-test-laws").resolve(file),
                        folder.resolve(file));
        return Files.move(copy, world.laws().resolve(file));
    }

    private static List<ProcessHandle> hosts(Server server) {
        return server.process()
                .descendants()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .toList();
    }

    /** Number of agents that perceive the world. */
    private static final int AGENTS = 100;

    /** An agent that perceives each frame on a thread of its own, until the connection ends. */
    private static final class Watcher {
        private final AgentClient client;
        private volatile long frame;
        private volatile @Nullable RuntimeException failure;

        Watcher(int port, String name) throws IOException {
            client = Agents.join(port, name);
            Thread.ofVirtual().start(this::perceive);
        }

        private void perceive() {
            try {
                while (true) {
                    frame = client.perceive().frame();
                }
            } catch (RuntimeException e) {
                failure = e;
            }
        }

        void awaitFrame(long wanted) throws InterruptedException {
            while (frame < wanted) {
                RuntimeException lost = failure;
                if (lost != null) {
                    throw new AssertionError("an agent perceived nothing after " + frame, lost);
                }
                Thread.sleep(5);
            }
        }
    }

    /**
     * The laws do harm from the 50th step of the world on. In this test, each law does harm in its
     * first frame. Therefore the world equals a world that never had the law.
     */
    @Test
    void aServerOutlivesLawsThatHarmTheirProcess() throws Exception {
        Map<String, String> kinds = new LinkedHashMap<>();
        kinds.put("segfault", "LAW_CRASHED");
        kinds.put("abort", "LAW_CRASHED");
        kinds.put("_exit", "LAW_CRASHED");
        kinds.put("overflow", "LAW_CRASHED");
        kinds.put("loop", "LAW_TIMED_OUT");
        kinds.put("sleep", "LAW_TIMED_OUT");
        kinds.put("segfault_in_bind", "LAW_CRASHED");
        kinds.put("segfault_in_constructor", "LIBRARY_LOAD_FAILED");
        kinds.put("_exit_in_destroy", "LIBRARY_LOAD_FAILED");
        JsonNode end;
        try (Server server = world.serve()) {
            List<Watcher> watchers = new ArrayList<>();
            int port = Integer.parseInt(server.port());
            for (int i = 0; i < AGENTS; i++) {
                watchers.add(new Watcher(port, "agent" + i));
            }
            try (AgentClient agent = Agents.join(port, "ada")) {
                while (agent.perceive().frame() <= StoneWorld.HARMLESS_STEPS) {}
                for (Map.Entry<String, String> kind : kinds.entrySet()) {
                    Path file = drop(kind.getKey());
                    int seen = server.events().count();
                    JsonNode fault =
                            server.events()
                                    .await(
                                            "fault",
                                            event ->
                                                    server.events().isAfter(event, seen)
                                                            && event.toString()
                                                                    .contains("hostile"));
                    assertThat(fault.path("status").asString())
                            .as(kind.getKey() + ": " + fault)
                            .isEqualTo(kind.getValue());
                    Files.delete(file);
                }
                long now = agent.perceive().frame();
                for (Watcher watcher : watchers) {
                    watcher.awaitFrame(now); // all agents are still connected
                }
            }
            for (Watcher watcher : watchers) {
                watcher.client.close();
            }
            for (int i = 0; i < AGENTS; i++) { // the bodies are items of the world
                String name = "\"agent" + i + "\"";
                server.events().await("left", event -> event.toString().contains(name));
            }
            server.events().await("left", event -> event.toString().contains("\"ada\""));
            server.process().toHandle().destroy();
            end = server.events().await("end", event -> true);
        }
        double seconds = end.path("frames").asLong() / 60.0;
        Reve.Outcome without =
                Reve.run(
                        "run",
                        world.file().toString(),
                        "--engine",
                        "in-process",
                        "--json",
                        "--seconds",
                        Double.toString(seconds));
        assertThat(without.out()).contains(end.path("stateHash").asString());
    }

    /** Least number of frames in which the law prints. */
    private static final long PRINTING_FRAMES = 60;

    /** The output of a law is no event. */
    @Test
    void aLawThatPrintsForgesNoEvent() throws Exception {
        drop("print");
        try (Server server = world.serve()) {
            long loaded =
                    server.events()
                            .await(
                                    "law-loaded",
                                    event -> event.path("library").asString().equals("hostile"))
                            .path("frame")
                            .asLong();
            long last = Math.max(loaded, StoneWorld.HARMLESS_STEPS) + PRINTING_FRAMES;
            try (AgentClient agent = Agents.join(Integer.parseInt(server.port()), "ada")) {
                while (agent.perceive().frame() <= last) {}
            }
            server.process().toHandle().destroy();
            List<JsonNode> events = server.events().untilEnd();
            assertThat(events)
                    .filteredOn(event -> event.path("event").asString().equals("law-loaded"))
                    .anySatisfy(
                            event ->
                                    assertThat(event.path("library").asString())
                                            .isEqualTo("hostile"));
            assertThat(events)
                    .filteredOn(event -> event.path("event").asString().equals("end"))
                    .singleElement()
                    .satisfies(end -> assertThat(end.path("frames").asLong()).isGreaterThan(1));
            assertThat(server.exitCode()).isZero();
        }
        assertThat(Files.readString(folder.resolve("server.err"))).contains("printed by a law");
    }

    /** Number of servers that are killed: 1 in a short run, 200 in a complete one. */
    private static final int KILLS = Integer.getInteger("reve.test.server.kills", 1);

    /** The time limit is that of 200 kills. */
    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void theProcessesOfLawsEndWithTheirServer() throws Exception {
        for (int kill = 0; kill < KILLS; kill++) {
            List<ProcessHandle> hosts;
            try (Server server = world.serve()) {
                server.port();
                hosts = hosts(server);
                assertThat(hosts).isNotEmpty();
                server.process().destroyForcibly();
                server.process().onExit().join();
                for (ProcessHandle host : hosts) {
                    host.onExit().get(300, TimeUnit.SECONDS);
                }
            }
            assertThat(hosts).noneMatch(ProcessHandle::isAlive);
            try (Stream<Path> shared = Files.list(Path.of("/dev/shm"))) {
                assertThat(shared.map(file -> file.getFileName().toString()))
                        .noneMatch(name -> name.contains("vesper") || name.contains("reve"));
            }
        }
    }

    /**
     * The store contains the quarantine. Therefore a law that crashed does not crash again after
     * the next start.
     */
    @Test
    void aStoreDoesNotRepeatACrash() throws Exception {
        String store = folder.resolve("stones.db").toString();
        drop("segfault");
        try (Server server = world.serve("--store", store)) {
            server.events()
                    .await("fault", fault -> fault.path("status").asString().equals("LAW_CRASHED"));
            server.process().toHandle().destroy();
            server.events().await("end", event -> true);
        }
        try (Server server = world.serve("--store", store)) {
            server.events().await("fault", Server::isFault);
            server.process().toHandle().destroy();
            List<JsonNode> events = server.events().untilEnd();
            assertThat(events)
                    .filteredOn(Server::isFault)
                    .as("the file is refused, and nothing crashes")
                    .isNotEmpty()
                    .allSatisfy(
                            fault ->
                                    assertThat(fault.path("message").asString())
                                            .contains("in quarantine since frame"));
            assertThat(server.exitCode()).isZero();
        }
    }
}
