// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.Stream;

/** Follows docs/laws-in-python.md, and then does what a reader may do next. */
@Tag("slow")
class LawsInPythonIT {
    private static final String LINE = "force -= 2 * mass[:, None] * numpy.cross(OMEGA, velocity)";

    private final Path folder;
    private final Shell shell;
    private final Document page;

    LawsInPythonIT(@TempDir Path folder) throws IOException {
        this.folder = folder;
        shell = new Shell(folder);
        page = Document.read(Project.ROOT.resolve("docs/laws-in-python.md"));
    }

    private String law() {
        return page.titled("spin.py").text();
    }

    private String run(String title) throws Exception {
        return shell.run(page.titled(title).text());
    }

    private String control(Server server, String request) throws Exception {
        return shell.run("\"$REVE/reve\" control --port " + server.port() + " " + request);
    }

    /** Puts a complete file into the laws folder. */
    private void drop(String text) throws IOException {
        Path copy = Files.writeString(folder.resolve("copy"), text);
        Files.move(copy, folder.resolve("laws/spin.py"), StandardCopyOption.REPLACE_EXISTING);
    }

    @Test
    void aLawIsDroppedShownMistakenAndRemoved() throws Exception {
        Files.writeString(folder.resolve("spin.py"), law());
        String serve = "export REVE_LOG=INFO\n" + page.titled("serve.sh").text();
        try (Server server = shell.serve(serve)) {
            server.port();
            run("drop.sh");
            server.events().await("law-loaded", event -> named(event, "spin"));
            assertThat(shell.messages()).containsPattern("spin: Python 3\\.\\d+\\.\\d+, NumPy 1");
            assertThat(control(server, "laws")).contains("spin", "Coriolis force");
            drop(law().replace("\"m/s\"", "\"N\""));
            assertThat(server.events().await("fault", event -> true).path("message").asString())
                    .isEqualTo(page.titled("mistake").text().strip());
            assertThat(control(server, "laws")).contains("Coriolis force");
            run("remove.sh");
            server.events().await("law-unloaded", event -> named(event, "spin"));
        }
    }

    @Test
    void theLawOfThePageKeepsTheContract() throws Exception {
        Files.writeString(folder.resolve("spin.py"), law());
        assertThat(run("test.sh")).contains("PASS  rollback", " 0 failed, ");
        Files.writeString(
                folder.resolve("spin.py"),
                law().replace(LINE, "OMEGA[1] += 1; " + LINE + "  # remembers"));
        assertThatThrownBy(() -> run("test.sh")).hasMessageContaining("after a rollback");
    }

    @Test
    void aLawWithTypesKeepsTheContract() throws Exception {
        Files.writeString(folder.resolve("drag.py"), page.titled("drag.py").text());
        assertThat(shell.run(page.titled("test.sh").text().replace("spin.py", "drag.py")))
                .contains("PASS  rollback", "PASS  guard-pages", " 0 failed, ");
        Files.writeString(
                folder.resolve("timed.py"),
                """
                from __future__ import annotations

                from typing import Annotated

                import numpy
                import vesper


                @vesper.law(phase="force")
                def timed(
                    time: float, force: Annotated[numpy.ndarray, "m", vesper.Accumulate("body", "N")]
                ) -> None:
                    "Force along x that grows with the time."
                    force[:, 0] += time
                """);
        assertThat(shell.run(page.titled("test.sh").text().replace("spin.py", "timed.py")))
                .contains("PASS  rollback", " 0 failed, ");
        Files.writeString(
                folder.resolve("drag.py"),
                page.titled("drag.py")
                        .text()
                        .replace("numpy.ndarray, vesper.Read(", "vesper.Read("));
        assertThatThrownBy(() -> shell.run(page.titled("test.sh").text().replace("spin", "drag")))
                .hasMessageContaining("Annotated");
    }

    @Test
    void theEnergyOfThePageBelongsToItsForces() throws Exception {
        Files.writeString(folder.resolve("well.py"), page.titled("well.py").text());
        assertThat(run("test-energy.sh"))
                .contains("PASS  potential-energy", "PASS  energy", " 0 failed, ");
        Files.writeString(
                folder.resolve("well.py"),
                page.titled("well.py").text().replace("0.5 * stiffness", "0.4 * stiffness"));
        assertThatThrownBy(() -> run("test-energy.sh"))
                .hasMessageContaining("FAIL  potential-energy")
                .hasMessageContaining("FAIL  energy");
    }

    /** Makes a virtual environment with a distribution of one module, {@code stiff}. */
    private Path environment() throws Exception {
        shell.run(page.titled("environment.sh").text().lines().findFirst().orElseThrow());
        Path environment = folder.resolve("environment");
        try (Stream<Path> all = Files.walk(environment.resolve("lib"), 2)) {
            Path packages =
                    all.filter(path -> path.endsWith("site-packages")).findFirst().orElseThrow();
            Files.writeString(packages.resolve("stiff.py"), "K = 1.0\n");
            Path info = Files.createDirectory(packages.resolve("stiffness-1.0.dist-info"));
            Files.writeString(info.resolve("RECORD"), "stiff.py,,\n");
            release(info, "1.2");
        }
        return environment;
    }

    private static void release(Path distribution, String version) throws IOException {
        Files.writeString(
                distribution.resolve("METADATA"),
                "Metadata-Version: 2.1\nName: stiffness\nVersion: " + version + "\n");
    }

    @Test
    void aReplayWithOtherVersionsWarnsAndNamesBoth() throws Exception {
        Path environment = environment();
        Path info;
        try (Stream<Path> all = Files.walk(environment)) {
            info = all.filter(path -> path.endsWith("stiffness-1.0.dist-info")).findAny().get();
        }
        Path world = turning();
        drop("import stiff\n" + law().replace("2 * mass", "2 * stiff.K * mass"));
        String log = folder.resolve("run.log").toString();
        List<String> python = List.of("--trust", "--python", environment.toString());
        Reve.Outcome run = reve(python, "run", world.toString(), "--seconds", "1", "--record", log);
        assertThat(run.code()).as(run.err()).isZero();
        List<String> serve = new ArrayList<>(List.of("serve", world.toString(), "--port", "0"));
        serve.addAll(List.of("--seconds", "0.2", "--store", folder.resolve("kept.db").toString()));
        assertThat(reve(python, serve.toArray(String[]::new)).code()).isZero();

        Reve.Outcome same = reve(python, "replay", log);
        assertThat(same.out()).as(same.err()).startsWith("identical: 60 frames");
        assertThat(same.err()).doesNotContain("was recorded with");
        release(info, "1.3");
        String both =
                "law spin was recorded with Python 3\\.[0-9.]+, NumPy [0-9.]+, stiffness 1\\.2, and"
                        + " here it runs with Python 3\\.[0-9.]+, NumPy [0-9.]+, stiffness 1\\.3:";
        Reve.Outcome other = reve(python, "replay", log);
        assertThat(other.out()).startsWith("identical: 60 frames");
        assertThat(other.err()).containsPattern(both);
        assertThat(reve(python, serve.toArray(String[]::new)).err()).containsPattern(both);
        assertThat(reve(List.of("--trust"), "replay", log).err())
                .contains("No module named 'stiff'; used /usr/bin/python3", "--python DIR");
    }

    private static Reve.Outcome reve(List<String> options, String... command) throws Exception {
        List<String> all = new ArrayList<>(List.of(command));
        all.addAll(options);
        return Reve.run(all.toArray(String[]::new));
    }

    @Test
    void aFolderThatIsNoVirtualEnvironmentIsRefused() throws Exception {
        String world = turning().toString();
        assertThat(Reve.run("check", world, "--python", folder.toString()).err())
                .contains("is no virtual environment", "pyvenv.cfg", "-m venv");
        Files.createFile(folder.resolve("pyvenv.cfg"));
        assertThat(
                        reve(
                                        List.of("--python", folder.toString()),
                                        "check",
                                        world,
                                        "--engine",
                                        "in-process")
                                .err())
                .contains("remove --engine in-process");
    }

    private Path turning() throws IOException {
        Files.createDirectories(folder.resolve("laws"));
        return Files.writeString(
                folder.resolve("world.yaml"),
                """
                reve: 1
                name: turning
                laws: [newton_motion, spin]
                items:
                  - {name: stone, physics: {mass: 2 kg, velocity: [3, 1, 4]}}
                """);
    }

    private static boolean named(JsonNode event, String library) {
        return event.path("library").asString("").equals(library);
    }

    /** Each fault has a file with other content. Therefore no file is already in quarantine. */
    @Test
    void aServerOutlivesLawsThatFail() throws Exception {
        Map<String, String> faults = new LinkedHashMap<>();
        faults.put("1 / 0", "LAW_FAILED");
        faults.put("force += numpy.inf", "LAW_MISBEHAVED");
        faults.put("while True: pass", "LAW_TIMED_OUT");
        faults.put("import os; os._exit(3)", "LAW_CRASHED");
        faults.put("import ctypes; ctypes.memset(8, 0, 8)", "LAW_CRASHED");
        try (Server server = shell.serve(page.titled("serve.sh").text())) {
            server.port();
            for (Map.Entry<String, String> fault : faults.entrySet()) {
                int seen = server.events().count();
                drop(law().replace(LINE, fault.getKey()));
                JsonNode event =
                        server.events().await("fault", each -> server.events().isAfter(each, seen));
                assertThat(event.path("status").asString())
                        .as(event.toString())
                        .isEqualTo(fault.getValue());
                if (fault.getKey().equals("1 / 0")) {
                    assertThat(event.path("message").asString())
                            .endsWith(page.titled("exception").text().strip());
                }
            }
            int seen = server.events().count();
            drop(law());
            server.events().await("law-loaded", each -> server.events().isAfter(each, seen));
        }
    }

    @Test
    void aStoreContinuesWithTheLaw() throws Exception {
        String serve = page.titled("serve.sh").text().strip() + " --store \"$PWD/store.db\"";
        try (Server server = shell.serve(serve)) {
            server.port();
            drop(law());
            server.events().await("law-loaded", event -> named(event, "spin"));
            control(server, "shut-down");
            server.events().await("end", event -> true);
        }
        try (Server server = shell.serve(serve)) {
            server.port();
            assertThat(control(server, "laws")).contains("Coriolis force");
            run("remove.sh");
            server.events().await("law-unloaded", event -> named(event, "spin"));
        }
    }

    @Test
    void aClientCannotSendOne() throws Exception {
        Files.writeString(folder.resolve("spin.py"), law());
        String serve = page.titled("serve.sh").text().strip() + " --trust";
        try (Server server = shell.serve(serve)) {
            assertThatThrownBy(() -> control(server, "load-law file=spin.py"))
                    .hasMessageContaining("spin.py is in Python")
                    .hasMessageContaining("folder of --laws");
            Files.move(folder.resolve("spin.py"), folder.resolve("spin.law"));
            assertThatThrownBy(() -> control(server, "load-law file=spin.law"))
                    .hasMessageContaining("spin.law is in Python");
        }
    }

    @Test
    void aRecordingRepeatsToTheBitIfItIsTrusted() throws Exception {
        Path world = turning();
        drop(law());
        String log = folder.resolve("run.log").toString();
        Reve.Outcome run =
                Reve.run("run", world.toString(), "--seconds", "2", "--trust", "--record", log);
        assertThat(run.code()).as(run.err()).isZero();
        Reve.Outcome trusted = Reve.run("replay", log, "--trust");
        assertThat(trusted.out()).as(trusted.err()).startsWith("identical: 120 frames");
        String laws = folder.resolve("laws").toString();
        assertThat(Reve.run("replay", log, "--laws", laws).out()).startsWith("identical: 120");
        assertThat(Reve.run("replay", log).err()).contains("law library 'spin'", "--trust");
    }
}
