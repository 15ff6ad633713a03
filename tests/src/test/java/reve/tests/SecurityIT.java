// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.DisconnectedException;
import reve.agent.Join;
import reve.agent.Trust;
import reve.tests.Reve.Outcome;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.stream.Stream;

/** Follows docs/security.md, block by block, and tries what the page forbids. */
@Tag("slow")
class SecurityIT {
    private final Path folder;
    private final Shell shell;
    private final Document page;

    SecurityIT(@TempDir Path folder) throws IOException {
        this.folder = folder;
        shell = new Shell(folder);
        page = Document.read(Project.ROOT.resolve("docs/security.md"));
    }

    @Test
    void agentsComeInByTheirTokensOverTlsAndNoSecretIsWrittenDown() throws Exception {
        assertThat(run("token.sh"))
                .contains("ada roles=[agent]", "boss roles=[control, observer] expires=");
        run("certificate.sh");
        List<String> secrets = new ArrayList<>(List.of(read("ada.token"), read("boss.token")));
        String serve =
                "REVE_LOG=DEBUG "
                        + page.titled("serve.sh").text().strip()
                        + " --audit audit.jsonl --record run.log --store store.db";
        try (Server server = shell.serve(serve)) {
            int port = Integer.parseInt(server.port());
            assertThat(server.events().await("ready", any -> true).get("agents").asString())
                    .isEqualTo("0.0.0.0:" + port);
            assertThat(python(port)).contains("ada is ada in spring-orbit");
            assertThat(java(port)).contains("spring-orbit has ");
            secrets.add(refusals(port));
            server.process().toHandle().destroy();
            server.exitCode();
        }
        for (String secret : List.of("ada.token", "boss.token", "tokens.json", "audit.jsonl")) {
            assertThat(
                            PosixFilePermissions.toString(
                                    Files.getPosixFilePermissions(folder.resolve(secret))))
                    .as(secret)
                    .isEqualTo("rw-------");
        }
        for (Path file : files()) {
            String text = Files.readString(file, StandardCharsets.ISO_8859_1);
            assertThat(secrets).as(file.toString()).noneMatch(text::contains);
        }
    }

    /**
     * @return a session's secret
     */
    private String refusals(int port) throws Exception {
        Join ada = Join.as("ada").withGrace(Duration.ofSeconds(5));
        Path trusted = folder.resolve("server.crt");
        refused(port, ada, "tls-expected");
        refused(port, ada.withTls(Trust.system()), "tls-failed");
        refused(port, ada.withTls(Trust.file(trusted)), "bad-token");
        refused(
                port,
                ada.withTls(Trust.file(trusted)).withToken(read("boss.token")),
                "not-permitted");
        refused(
                port,
                ada.withTls(Trust.file(trusted)).withToken(read("ada.token")).withRole("control"),
                "not-permitted");
        try (AgentClient client =
                Agents.join(
                        "localhost",
                        port,
                        ada.withTls(Trust.file(trusted)).withToken(read("ada.token")))) {
            String session = client.welcome().session().orElseThrow().token();
            shell.run("\"$REVE/reve\" token revoke ada --file tokens.json");
            assertThatExceptionOfType(DisconnectedException.class)
                    .isThrownBy(
                            () -> {
                                while (true) {
                                    client.perceive();
                                }
                            })
                    .satisfies(e -> assertThat(e.code()).isEqualTo("token-revoked"));
            return session;
        }
    }

    private static void refused(int port, Join join, String code) {
        assertThatExceptionOfType(DisconnectedException.class)
                .isThrownBy(() -> Agents.join("localhost", port, join).close())
                .satisfies(e -> assertThat(e.code()).isEqualTo(code));
    }

    @Test
    void anAddressThatOthersReachTakesTokensAndTls() throws Exception {
        String world = Project.WORLDS.resolve("spring-orbit").toString();
        Outcome open = Reve.run("serve", world, "--listen", "0.0.0.0", "--port", "0");
        assertThat(open.code()).isEqualTo(5);
        assertThat(open.err())
                .contains(
                        "./reve token new NAME --file tokens.json",
                        "openssl req -x509",
                        "--tokens tokens.json --tls-certificate server.crt --tls-key server.key");
        Outcome half = Reve.run("serve", world, "--tls-key", "server.key", "--port", "0");
        assertThat(half.code()).isEqualTo(2);
        assertThat(half.err()).contains("belong together");
        Outcome missing =
                Reve.run("serve", world, "--tokens", folder.resolve("none.json").toString());
        assertThat(missing.code()).isEqualTo(1);
        assertThat(missing.err()).contains("none.json", "`token new NAME");
        Outcome unknown =
                Reve.run(
                        "token", "revoke", "ada", "--file", folder.resolve("none.json").toString());
        assertThat(unknown.code()).isEqualTo(1);
        assertThat(Reve.run("token", "new", "a b").err()).contains("no name for a client");
        Outcome over =
                Reve.run(
                        "token",
                        "new",
                        "ada",
                        "--expires",
                        "2020-01-31T12:00:00Z",
                        "--file",
                        folder.resolve("over.json").toString());
        assertThat(over.code()).isEqualTo(2);
        assertThat(over.err())
                .contains(
                        "--expires 2020-01-31T12:00:00Z is over already",
                        "`./reve token new --help` says more");
        assertThat(folder.resolve("over.json")).doesNotExist();
        assertThat(Reve.run("token").err()).contains("new, list, revoke");
    }

    @Test
    void aTokenIsNeverWrittenOverAFileNorLeftBehind() throws Exception {
        Path tokens = folder.resolve("tokens.json");
        Path existing = Files.writeString(folder.resolve("there"), "mine");
        Outcome over =
                Reve.run(
                        "token",
                        "new",
                        "ada",
                        "--file",
                        tokens.toString(),
                        "--out",
                        existing.toString());
        assertThat(over.code()).isEqualTo(1);
        assertThat(over.err()).contains("--out " + existing + " is there already");
        assertThat(existing).hasContent("mine");
        assertThat(tokens).doesNotExist();
        Path next = folder.resolve("next");
        assertThat(
                        Reve.run(
                                        "token",
                                        "new",
                                        "ada",
                                        "--file",
                                        folder.resolve("no/tokens").toString(),
                                        "--out",
                                        next.toString())
                                .code())
                .isEqualTo(1);
        assertThat(next).doesNotExist();
    }

    /**
     * A name of an image that prints a false event and controls the terminal, if it is not escaped.
     */
    @Test
    void namesOfImagesForgeNoEventsNoLogLinesAndNoAnswers() throws Exception {
        String name = "x\n\u001b[2Jfault source=world message=gone";
        Path err = folder.resolve("server.err");
        Process server =
                new ProcessBuilder(
                                Reve.command(
                                        "serve",
                                        Project.WORLDS.resolve("spring-orbit").toString(),
                                        "--port",
                                        "0"))
                        .redirectError(err.toFile())
                        .start();
        try (BufferedReader events = server.inputReader()) {
            String ready = events.readLine();
            String port = ready.replaceFirst(".* agentPort=(\\d+) .*", "$1");
            Outcome refused = Reve.run("control", "rewind", "image=" + name, "--port", port);
            assertThat(refused.code()).isEqualTo(1);
            assertThat(refused.err().lines())
                    .singleElement()
                    .asString()
                    .startsWith("reve: no-such-image: ")
                    .contains("x\\u{a}\\u{1b}[2Jfault");
            for (String command : List.of("snapshot", "rewind")) {
                assertThat(Reve.run("control", command, "image=" + name, "--port", port).code())
                        .isZero();
            }
            String event = events.readLine();
            while (event.startsWith("law-loaded")) {
                event = events.readLine();
            }
            assertThat(event)
                    .startsWith("rewound frame=")
                    .endsWith("image=x\\u{a}\\u{1b}[2Jfault source=world message=gone");
        } finally {
            server.toHandle().destroy();
            server.waitFor();
        }
        assertThat(err).content().doesNotContain("\nfault", "\u001b");
    }

    private String asEve(Server server, String request) throws Exception {
        return shell.run(
                "REVE_TOKEN=$(cat eve.token) \"$REVE/reve\" control --name eve --port "
                        + server.port()
                        + " "
                        + request);
    }

    @Test
    void aTokenOfSingleLawsChangesOnlyThese() throws Exception {
        run("laws.sh");
        String wind = "law wind\n  each body:\n    force -= 1 kg/s * velocity\n";
        Files.writeString(folder.resolve("wind.law"), wind);
        String serve = "\"$REVE/reve\" serve \"$REVE/worlds/spring-orbit\" --tokens tokens.json";
        try (Server server = shell.serve(serve)) {
            assertThat(asEve(server, "load-law file=wind.law")).startsWith("load-law: frame ");
            assertThat(asEve(server, "laws")).contains("\"wind\"");
            // The name of the file is not that of the law.
            Files.writeString(folder.resolve("wind.law"), wind.replace("law wind", "law storm"));
            assertThatThrownBy(() -> asEve(server, "load-law file=wind.law"))
                    .hasMessageContaining("not-permitted")
                    .hasMessageContaining("it may change only the laws drag.c, wind, not storm");
            assertThatThrownBy(() -> asEve(server, "load-law library=gravity_feld"))
                    .as("only clients that may load the law learn the reason")
                    .hasMessageContaining(
                            "law-refused: the library \"gravity_feld\" is refused; the server's"
                                    + " log says why");
            for (String other :
                    List.of(
                            "pause",
                            "unload-law library=newton_motion",
                            "edit item=blue property=mass value=3")) {
                assertThatThrownBy(() -> asEve(server, other))
                        .as(other)
                        .hasMessageContaining("it may change only the laws drag.c, wind");
            }
            assertThat(asEve(server, "laws")).doesNotContain("storm").contains("newton_motion");
            assertThat(asEve(server, "unload-law library=wind")).startsWith("unload-law: frame ");
        }
    }

    private String run(String block) throws Exception {
        return shell.run(page.titled(block).text());
    }

    private String python(int port) throws Exception {
        write("ada.py", port);
        return shell.run("PYTHONPATH=\"$REVE/agents/python\" python3 ada.py");
    }

    private String java(int port) throws Exception {
        write("Boss.java", port);
        return shell.run(
                System.getProperty("java.home")
                        + "/bin/java -cp \"$REVE/build/stage/lib/*\" Boss.java");
    }

    private void write(String program, int port) throws IOException {
        Files.writeString(
                folder.resolve(program), page.titled(program).text().replace("7777", "" + port));
    }

    private String read(String file) throws IOException {
        return Files.readString(folder.resolve(file)).strip();
    }

    /** Returns all written text except the token files. */
    private List<Path> files() throws IOException {
        try (Stream<Path> files = Files.walk(folder)) {
            return files.filter(Files::isRegularFile)
                    .filter(file -> !file.toString().endsWith(".token"))
                    .toList();
        }
    }
}
