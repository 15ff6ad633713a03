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
import java.util.LinkedHashMap;
import java.util.Map;

/** Does what docs/laws-in-python.md says, and what its reader may do next. */
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

    /** Puts a file into the laws folder at once. */
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

    private static boolean named(JsonNode event, String library) {
        return event.path("library").asString("").equals(library);
    }

    /** Each fault is that of another content, so none of them is quarantined before. */
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
        Path world = folder.resolve("world.yaml");
        Files.writeString(
                world,
                """
                reve: 1
                name: turning
                laws: [newton_motion, spin]
                items:
                  - {name: stone, physics: {mass: 2 kg, velocity: [3, 1, 4]}}
                """);
        Files.createDirectory(folder.resolve("laws"));
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
