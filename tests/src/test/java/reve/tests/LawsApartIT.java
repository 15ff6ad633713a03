// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.concurrent.TimeUnit;
import java.util.stream.Collectors;

/** Laws that the operator does not trust, and laws of worlds, each in a sandbox. */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class LawsApartIT {
    @TempDir private Path folder;

    private Path untrusted;

    @BeforeEach
    void makeFolder() throws Exception {
        untrusted = Files.createDirectory(folder.resolve("untrusted"));
    }

    private String world(String laws) throws Exception {
        return Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: visited
                        laws: %s
                        items:
                          - {name: one, physics: {mass: 1 kg, velocity: [1, 0, 0]}}
                        """
                                .formatted(laws))
                .toString();
    }

    private static Path testLaw(String name) {
        return Project.NATIVE.resolve("adapter-test-laws/libvesper_law_" + name + ".so");
    }

    /** Puts a complete test law into a folder. */
    private Path drop(String name, Path into) throws Exception {
        Path law = testLaw(name);
        Path copy = Files.copy(law, folder.resolve(law.getFileName()));
        return Files.move(copy, into.resolve(law.getFileName()), StandardCopyOption.ATOMIC_MOVE);
    }

    private static Outcome reve(List<String> command, String... more) throws Exception {
        List<String> all = new ArrayList<>(command);
        all.addAll(List.of(more));
        return Reve.run(all.toArray(String[]::new));
    }

    private static String hash(Outcome run) throws Exception {
        assertThat(run.code()).as(run.err()).isZero();
        return new JsonMapper().readTree(run.out()).get("stateHash").asString();
    }

    @Test
    void lawsOfAWorldRunApartInsteadOfBeingRefused() throws Exception {
        drop("wind", Files.createDirectory(folder.resolve("laws")));
        String world = world("[newton_motion, wind]");
        List<String> run = List.of("run", world, "--seconds", "0.1", "--json");
        Outcome refused = reve(run);
        assertThat(refused.code()).isEqualTo(4);
        assertThat(refused.err()).contains("only with --trust, or in a sandbox with --apart");
        String trusted = hash(reve(run, "--trust"));
        assertThat(hash(reve(run, "--apart"))).isEqualTo(trusted);
        assertThat(reve(List.of("check", world, "--apart")).out())
                .contains("valid, 1 items, 2 laws\n");
        Path picture = folder.resolve("p.png");
        assertThat(reve(List.of("picture", world, "--out", picture.toString()), "--apart").code())
                .isZero();
        Outcome inProcess = reve(run, "--apart", "--engine", "in-process");
        assertThat(inProcess.code()).isEqualTo(2);
        assertThat(inProcess.err()).contains("remove --engine in-process");
    }

    @Test
    void aRecordingOfUntrustedLawsIsReplayedApart() throws Exception {
        drop("wind", untrusted);
        String world = world("[newton_motion, wind]");
        String log = folder.resolve("r.log").toString();
        List<String> run = List.of("run", world, "--seconds", "0.1", "--json");
        String hash = hash(reve(run, "--untrusted", untrusted.toString(), "--record", log));
        assertThat(hash(reve(run, "--laws", untrusted.toString()))).isEqualTo(hash);
        List<String> replay = List.of("replay", log);
        Outcome refused = reve(replay);
        assertThat(refused.code()).isEqualTo(4);
        assertThat(refused.err()).contains("is native code", "in a sandbox with --apart");
        for (List<String> option :
                List.of(List.of("--apart"), List.of("--untrusted", untrusted.toString()))) {
            Outcome replayed = reve(replay, option.toArray(String[]::new));
            assertThat(replayed.out()).as(replayed.err()).startsWith("identical: 6 frames");
        }
        // The account remembers which libraries were in the folder, even after their files were
        // removed.
        Files.delete(untrusted.resolve("libvesper_law_wind.so"));
        Outcome gone = reve(replay, "--untrusted", untrusted.toString());
        assertThat(gone.out()).as(gone.err()).startsWith("identical: 6 frames");
        Path other = Files.createDirectory(folder.resolve("other"));
        assertThat(reve(replay, "--untrusted", other.toString()).code()).isEqualTo(4);
    }

    /** The recording contains the decision that the clock made. */
    @Test
    void aMissedDeadlineOfALawApartIsReplayed() throws Exception {
        drop("hostile_loop", untrusted);
        String log = folder.resolve("r.log").toString();
        String own = untrusted.toString();
        Outcome run =
                reve(
                        List.of("run", world("[newton_motion, hostile_loop]"), "--untrusted", own),
                        "--seconds",
                        "1",
                        "--law-deadline",
                        "100",
                        "--record",
                        log,
                        "--json");
        assertThat(run.code()).isEqualTo(1);
        assertThat(run.out()).contains("law hostile: no answer within 100 ms");
        String hash = new JsonMapper().readTree(run.out()).get("stateHash").asString();
        assertThat(reve(List.of("replay", log), "--untrusted", own).out())
                .contains("identical: 60 frames", hash);
    }

    @Test
    void aMachineWithoutALayerOfTheSandboxIsRefused() throws Exception {
        Path natives = Files.createDirectory(folder.resolve("native"));
        for (String file :
                List.of(
                        "libvesper.so.1",
                        "libvesper.so",
                        "vesper-host",
                        "vesper-probe",
                        "laws/libvesper_law_newton_motion.so")) {
            Files.createDirectories(natives.resolve(file).getParent());
            Files.copy(Project.NATIVE.resolve(file), natives.resolve(file));
        }
        Path sandbox = natives.resolve("vesper-sandbox");
        Files.writeString(
                sandbox,
                "#!/bin/sh\necho 'user namespace: yes'\necho 'Landlock: no (Function not"
                        + " implemented)'\nexit 1\n");
        assertThat(sandbox.toFile().setExecutable(true)).isTrue();
        String before = System.getProperty("reve.native.path");
        System.setProperty("reve.native.path", natives.toString());
        try {
            List<String> check = List.of("check", world("[newton_motion]"));
            Outcome refused = reve(check, "--untrusted", untrusted.toString());
            assertThat(refused.code()).isEqualTo(2);
            assertThat(refused.err())
                    .contains(
                            "lacks layers of the sandbox: Landlock: no (Function not implemented)",
                            "--weak-sandbox")
                    .doesNotContain("user namespace");
            assertThat(reve(check, "--untrusted", untrusted.toString(), "--weak-sandbox").code())
                    .isZero();
        } finally {
            System.setProperty("reve.native.path", before);
        }
    }

    private static Set<Long> hosts(Server server) {
        return server.process()
                .descendants()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .map(ProcessHandle::pid)
                .collect(Collectors.toSet());
    }

    /** Number of equal samples after which the hosts of a server are those that stay. */
    private static final int SAME_SAMPLES = 10;

    private static final long SAMPLE_MILLISECONDS = 500;

    /** Returns the hosts of a server, without a process that only tries a library and ends soon. */
    private static Set<Long> hostsThatStay(Server server) throws InterruptedException {
        Set<Long> before = hosts(server);
        for (int same = 1; same < SAME_SAMPLES; ) {
            Thread.sleep(SAMPLE_MILLISECONDS);
            Set<Long> now = hosts(server);
            same = now.equals(before) ? same + 1 : 1;
            before = now;
        }
        return before;
    }

    /** A fault of a law that runs apart changes neither the engine's process nor other laws. */
    @Test
    void aServerContainsLawsThatAreDropped() throws Exception {
        Map<String, String> kinds =
                Map.of(
                        "segfault", "LAW_CRASHED",
                        "loop", "LAW_TIMED_OUT",
                        "fork", "LAW_CRASHED",
                        "_exit_in_constructor", "LIBRARY_LOAD_FAILED");
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        world("[newton_motion]"),
                        "--port",
                        "0",
                        "--json",
                        "--untrusted",
                        untrusted.toString())) {
            drop("wind", untrusted);
            server.events().await("law-loaded", event -> event.toString().contains("wind"));
            JsonNode loaded = laws(server.port());
            assertThat(loaded.at("/0/library").asString()).isEqualTo("newton_motion");
            assertThat(loaded.at("/0/apart").isMissingNode()).isTrue();
            assertThat(loaded.at("/0/trust").asString()).isEqualTo("shipped");
            assertThat(loaded.at("/1/trust").asString()).isEqualTo("untrusted");
            assertThat(loaded.at("/1/library").asString()).isEqualTo("wind");
            assertThat(loaded.at("/1/apart").asBoolean()).isTrue();
            Set<Long> before = hostsThatStay(server);
            for (Map.Entry<String, String> kind : kinds.entrySet()) {
                int seen = server.events().count();
                Path file = drop("hostile_" + kind.getKey(), untrusted);
                JsonNode fault =
                        server.events()
                                .await("fault", event -> server.events().isAfter(event, seen));
                assertThat(fault.path("status").asString())
                        .as(fault.toString())
                        .isEqualTo(kind.getValue());
                assertThat(fault.toString()).contains("hostile");
                Files.delete(file);
            }
            assertThat(hosts(server)).containsAll(before);
            assertThat(laws(server.port()).findValuesAsString("library"))
                    .containsExactly("newton_motion", "wind");
            server.process().toHandle().destroy();
            assertThat(server.process().waitFor(300, TimeUnit.SECONDS)).isTrue();
        }
    }

    private static JsonNode laws(String port) throws Exception {
        Outcome asked = Reve.run("control", "laws", "--port", port);
        assertThat(asked.code()).as(asked.err()).isZero();
        return new JsonMapper().readTree(asked.out()).get("loaded");
    }
}
