// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.Join;

import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;

/** Clients can name native code of the server, but cannot send any. */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class NativeLawsOverTcpIT {
    private static final Path WIND =
            Project.NATIVE.resolve("adapter-test-laws/libvesper_law_wind.so");

    @TempDir private Path folder;

    private static AgentClient boss(Server server) throws Exception {
        return Agents.join(Integer.parseInt(server.port()), Join.as("boss").withRole("control"));
    }

    private static void awaitLoaded(Server server, int seen) throws Exception {
        server.events()
                .await(
                        "law-loaded",
                        event ->
                                server.events().isAfter(event, seen)
                                        && event.path("library").asString().equals("wind"));
    }

    @Test
    void aLibraryOfTheFolderIsLoadedAgainByItsName() throws Exception {
        StoneWorld world = StoneWorld.in(folder);
        Path copy = Files.copy(WIND, folder.resolve("copy.so"));
        try (Server server = world.serve();
                AgentClient boss = boss(server)) {
            Files.move(copy, world.laws().resolve("libvesper_law_wind.so"));
            awaitLoaded(server, 0);
            assertThat(boss.command("unload-law", Map.of("library", "wind")).accepted()).isTrue();
            int seen = server.events().count();
            ActResult loaded =
                    boss.command(
                            "load-law",
                            Map.of("library", "wind", "parameters", Map.of("force", 3.0)));
            assertThat(loaded.accepted()).as(loaded.toString()).isTrue();
            awaitLoaded(server, seen);
        }
    }

    /** Number of bytes of the library that fit into a line of the protocol. */
    private static final int SENT_BYTES = 9_000;

    @Test
    void nativeCodeThatAClientSendsIsRefused() throws Exception {
        StoneWorld world = StoneWorld.in(folder);
        String code =
                new String(Files.readAllBytes(WIND), StandardCharsets.ISO_8859_1)
                        .substring(0, SENT_BYTES);
        try (Server server = world.serve("--trust");
                AgentClient boss = boss(server)) {
            for (String name : new String[] {"wind", "wind.so", "wind.law"}) {
                for (String text : new String[] {code, code.substring(0, 100), WIND.toString()}) {
                    ActResult sent =
                            boss.command("load-law", Map.of("library", name, "text", text));
                    assertThat(sent.code()).as(name).contains("law-refused");
                }
                ActResult path = boss.command("load-law", Map.of("library", WIND.toString()));
                assertThat(path.code()).contains("law-refused");
            }
            Reve.Outcome control =
                    Reve.run("control", "load-law", "file=" + WIND, "--port", server.port());
            assertThat(control.code()).isEqualTo(2);
            assertThat(control.err()).contains("libvesper_law_wind.so");
            boss.command("shut-down", Map.of());
            assertThat(server.events().untilEnd().toString()).doesNotContain("\"wind\"");
        }
    }
}
