// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.core.agent.AgentServerConfig;
import reve.core.file.AgentPolicy;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.rule.Rules;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.PerformableAction;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;
import reve.worlds.journal.SqliteStore;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.RunReport;
import reve.worlds.server.ServerReport;
import reve.worlds.server.Simulation;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;

import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.Executor;
import java.util.concurrent.TimeUnit;

/** Each world in a server behaves as if it were alone, even if the other worlds fail. */
class SeveralWorldsIT {
    private static final int FRAMES = 120;
    private static final Executor THREADS = task -> Thread.ofPlatform().daemon().start(task);

    private final Path folder;
    private final List<String> faults = new ArrayList<>();

    SeveralWorldsIT(@TempDir Path folder) {
        this.folder = folder;
    }

    @Test
    void eachWorldIsToTheBitWhatItIsAlone() throws Exception {
        List<WorldDescription> worlds = List.of(read("spring-orbit"), read("icosahedron"));
        List<Long> alone = new ArrayList<>();
        for (WorldDescription world : worlds) {
            try (Simulation simulation = new Simulation(world, Pacing.FAST)) {
                simulation.loop().run(FRAMES);
                alone.add(simulation.physics().stateHash());
            }
        }
        try (WorldServer server = server(Pacing.FAST, FRAMES, worlds)) {
            assertThat(server.run().runs())
                    .extracting(RunReport::stateHash)
                    .containsExactlyElementsOf(alone);
        }
    }

    @Test
    void aWorldThatHangsDoesNotStopTheOthers() throws Exception {
        CountDownLatch hanging = new CountDownLatch(1);
        CountDownLatch released = new CountDownLatch(1);
        WorldDescription stuck =
                worldWith(
                        "stuck",
                        call -> {
                            hanging.countDown();
                            awaitQuietly(released);
                        });
        ServerReport report =
                serve(
                        List.of(stuck, read("spring-orbit")),
                        port -> {
                            try (AgentClient ada = join(port, "stuck");
                                    AgentClient bob = join(port, "spring-orbit")) {
                                CompletableFuture<?> act =
                                        CompletableFuture.supplyAsync(
                                                () -> ada.act("bomb", "go", Map.of()), THREADS);
                                assertThat(hanging.await(300, TimeUnit.SECONDS)).isTrue();
                                assertFramesAreMade(bob);
                                assertThat(
                                                bob.act(
                                                                "blue",
                                                                "push",
                                                                Map.of("impulse", List.of(0, 0, 1)))
                                                        .accepted())
                                        .isTrue();
                                released.countDown();
                                act.join();
                            } finally {
                                released.countDown();
                            }
                        });
        assertThat(report.failed()).isFalse();
    }

    @Test
    void aWorldThatFailsForGoodEndsAloneAndSaysWhy() throws Exception {
        WorldDescription doomed =
                worldWith(
                        "doomed",
                        call -> {
                            throw new OutOfMemoryError("as if");
                        });
        ServerReport report =
                serve(
                        List.of(doomed, read("spring-orbit")),
                        port -> {
                            try (AgentClient ada = join(port, "doomed");
                                    AgentClient bob = join(port, "spring-orbit")) {
                                CompletableFuture<?> act =
                                        CompletableFuture.supplyAsync(
                                                () -> ada.act("bomb", "go", Map.of()), THREADS);
                                assertThat(
                                                act.handle(
                                                                (result, failure) ->
                                                                        String.valueOf(failure))
                                                        .join())
                                        .contains("the world \"doomed\" ends");
                                assertFramesAreMade(bob);
                            }
                        });
        assertThat(report.failed()).isTrue();
        assertThat(report.runs()).extracting(RunReport::world).containsExactly("spring-orbit");
        assertThat(faults).anySatisfy(fault -> assertThat(fault).contains("doomed", "as if"));
    }

    private interface Client {
        void run(int port) throws Exception;
    }

    private ServerReport serve(List<WorldDescription> worlds, Client client) throws Exception {
        try (WorldServer server = server(Pacing.REAL_TIME, Long.MAX_VALUE, worlds)) {
            CompletableFuture<Void> done =
                    CompletableFuture.runAsync(
                            () -> {
                                try {
                                    client.run(server.port());
                                } catch (Exception e) {
                                    throw new IllegalStateException(e);
                                } finally {
                                    server.stop();
                                }
                            },
                            THREADS);
            ServerReport report = server.run();
            done.join();
            return report;
        }
    }

    private WorldServer server(Pacing pacing, long frames, List<WorldDescription> worlds)
            throws Exception {
        List<WorldPlan> plans =
                worlds.stream()
                        .map(
                                world ->
                                        new WorldPlan(
                                                world,
                                                frames,
                                                new Persistence(
                                                        folder,
                                                        Optional.empty(),
                                                        Optional.empty(),
                                                        Optional.empty(),
                                                        10,
                                                        SqliteStore.Durability.NORMAL),
                                                new Pictures(folder, List.of())))
                        .toList();
        return new WorldServer(
                plans, pacing, AgentServerConfig.onPort(0), Optional.empty(), this::note);
    }

    private synchronized void note(String event, Map<String, Object> fields) {
        if (event.equals("fault")) {
            faults.add(fields.toString());
        }
    }

    private static AgentClient join(int port, String world) throws Exception {
        return Agents.join(port, Join.as("someone").withWorld(world));
    }

    private static void assertFramesAreMade(AgentClient agent) {
        agent.perceiveEvery(1);
        long first = agent.nextPerception().frame();
        for (long frame = first; frame < first + 30; frame = agent.nextPerception().frame()) {
            // the client's time limit ends the test if no more arrive
        }
        agent.stopPerceiving();
    }

    private static WorldDescription read(String name) throws Exception {
        return WorldFile.load(Project.WORLDS.resolve(name).resolve("world.yaml"));
    }

    private interface Deed {
        void perform(ActionCall call);
    }

    private static WorldDescription worldWith(String name, Deed deed) {
        ItemDefinition body = ItemDefinition.named("body").shape(Shape.sphere(1)).build();
        Action go =
                new PerformableAction() {
                    @Override
                    public String name() {
                        return "go";
                    }

                    @Override
                    public String doc() {
                        return "Does what the test wants.";
                    }

                    @Override
                    public List<Parameter> parameters() {
                        return List.of();
                    }

                    @Override
                    public void perform(ActionCall call) {
                        deed.perform(call);
                    }
                };
        ItemDefinition bomb =
                ItemDefinition.named("bomb").shape(Shape.sphere(1)).action(go).build();
        return new WorldDescription(
                name,
                "",
                WorldPrototype.standard("si-f64"),
                Timing.DEFAULT,
                0,
                List.of(),
                Map.of(),
                Optional.empty(),
                new AgentPolicy(List.of(), Optional.of(body)),
                List.of(),
                Rules.DEFAULT_STEPS,
                List.of(bomb),
                List.of(),
                List.of());
    }

    private static void awaitQuietly(CountDownLatch latch) {
        try {
            latch.await();
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        }
    }
}
