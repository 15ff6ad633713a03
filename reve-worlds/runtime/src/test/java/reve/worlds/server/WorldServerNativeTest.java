// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.AgentServerConfig;
import reve.core.file.WorldFile;
import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsLaw;
import reve.pe.adapter.Laws;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.SqliteStore;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicReference;

/** The reports of a server when one of its worlds fails. */
class WorldServerNativeTest {
    @TempDir private Path folder;

    private WorldPlan plan(String world, long frames, Optional<Path> recording) throws Exception {
        Path file =
                Files.writeString(
                        folder.resolve(world + ".yaml"),
                        "reve: 1\nname: " + world + "\nitems: []\n");
        var persistence =
                new Persistence(
                        folder,
                        recording.map(RecordingPlan::of),
                        Optional.empty(),
                        Optional.empty(),
                        10,
                        SqliteStore.Durability.NORMAL);
        return new WorldPlan(
                WorldFile.load(file), frames, persistence, new Pictures(folder, List.of()));
    }

    /**
     * The recording cannot be written, and the journal cannot report it. This is an Error of the
     * journal.
     */
    @Test
    void aWorldWhoseJournalEndsIsReportedAsFailedAndTheOthersGoOn() throws Exception {
        var recording = Optional.of(folder.resolve("run.log"));
        Queue<String> told = new ConcurrentLinkedQueue<>();
        ServerEvents events =
                (event, fields) -> {
                    String message = String.valueOf(fields.get("message"));
                    if (message.contains("are not recorded, until")) {
                        throw new OutOfMemoryError("while it was told");
                    }
                    told.add(event + " of " + fields.get("world") + ": " + message);
                };
        var plans =
                List.of(
                        plan("kept", Long.MAX_VALUE, recording),
                        plan("other", 600, Optional.empty()));
        try (var server =
                new WorldServer(
                        plans,
                        Pacing.FAST,
                        AgentServerConfig.onPort(0),
                        Optional.empty(),
                        events)) {
            journalsThread().interrupt(); // which closes its file
            ServerReport report = server.run();
            assertThat(report.failed()).as("exit code 1 of serve").isTrue();
            assertThat(report.runs())
                    .singleElement()
                    .satisfies(
                            run -> {
                                assertThat(run.world()).isEqualTo("other");
                                assertThat(run.frames()).isEqualTo(600);
                            });
        }
        assertThat(told)
                .anySatisfy(
                        fault ->
                                assertThat(fault)
                                        .startsWith(
                                                "fault of kept: the world kept has ended:"
                                                        + " java.io.IOError")
                                        .contains(
                                                "the journal has ended after frame",
                                                "OutOfMemoryError: while it was told"));
    }

    /** An action of a world file may set any fields of an event. */
    @Test
    void anEventCannotSpeakForAnotherWorld() throws Exception {
        Queue<Object> worlds = new ConcurrentLinkedQueue<>();
        ServerEvents events =
                (event, fields) -> {
                    if (event.equals("rang")) {
                        worlds.add(fields.get("world"));
                    }
                };
        try (var server =
                new WorldServer(
                        List.of(
                                plan("mine", 3, Optional.empty()),
                                plan("other", 3, Optional.empty())),
                        Pacing.FAST,
                        AgentServerConfig.onPort(0),
                        Optional.empty(),
                        events)) {
            server.ports()
                    .getFirst()
                    .bus()
                    .subscribe(
                            FramePhase.ACT,
                            "bell",
                            frame ->
                                    frame.world()
                                            .raise(
                                                    new WorldEvent(
                                                            frame.frame(),
                                                            "rang",
                                                            Map.of("world", "other"))));
            server.run();
        }
        assertThat(worlds).isNotEmpty().containsOnly("mine");
    }

    /** A law that does not return would delay an event that follows its first step. */
    @Test
    void aLoadedLawIsReportedBeforeItsFirstStepAndOnce() throws Exception {
        Queue<String> told = new ConcurrentLinkedQueue<>();
        AtomicReference<Laws> laws = new AtomicReference<>();
        ServerEvents events =
                (event, fields) -> {
                    if (event.startsWith("law-")) {
                        long calls =
                                laws.get().loaded().stream()
                                        .filter(law -> law.name().equals(fields.get("library")))
                                        .mapToLong(PhysicsLaw::calls)
                                        .sum();
                        told.add(event + " " + fields.get("library") + " " + calls);
                    } else if (event.equals("rang")) {
                        told.add(event);
                    }
                };
        WorldPlan plan = plan("loading", 5, Optional.empty());
        try (HostedWorld world = new HostedWorld(plan, Pacing.FAST, Optional.empty(), events)) {
            Simulation simulation = world.simulation();
            laws.set(simulation.physics().laws());
            simulation
                    .commands()
                    .offer(
                            new Command() {
                                @Override
                                public String origin() {
                                    return "test";
                                }

                                @Override
                                public long sequence() {
                                    return 1;
                                }

                                @Override
                                public void execute(World inside, FrameEvent frame) {
                                    inside.raise(new WorldEvent(frame.frame(), "rang", Map.of()));
                                    laws.get().load(frame.frame(), "drag", Map.of());
                                }
                            });
            world.run();
            assertThat(laws.get().loaded())
                    .filteredOn(law -> law.name().equals("drag"))
                    .singleElement()
                    .satisfies(law -> assertThat(law.calls()).isPositive());
        }
        assertThat(told).containsExactly("rang", "law-loaded drag 0");
    }

    private static Thread journalsThread() {
        return Thread.getAllStackTraces().keySet().stream()
                .filter(thread -> thread.getName().equals("journal"))
                .findAny()
                .orElseThrow();
    }
}
