// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.MissingNode;

import java.io.IOException;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.FutureTask;

/** {@code ./reve control} and a server with two worlds, as processes. */
@Tag("slow")
class ControlCommandIT {

    @Test
    void aRunningWorldIsPausedTakenBackSavedAndEnded(@TempDir Path folder) throws Exception {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        Project.WORLDS.resolve("spring-orbit").toString(),
                        Project.WORLDS.resolve("icosahedron").toString(),
                        "--port",
                        "0",
                        "--json",
                        "--saves",
                        folder.toString())) {
            String port = server.port();
            assertThat(Reve.runAsProcess("control", "pause", "--port", port).err())
                    .contains("no-such-world", "icosahedron");
            assertThat(control(port, "pause").code()).isZero();
            long frame = Long.parseLong(control(port, "rewind").out().replaceAll("\\D", ""));
            assertThat(control(port, "step", "frames=5", "--json").out())
                    .contains("\"frame\" : " + (frame + 5));
            assertThat(control(port, "save", "file=later").code()).isZero();
            Reve.Outcome ofOther =
                    Reve.run(
                            "control",
                            "save",
                            "file=later",
                            "--port",
                            port,
                            "--world",
                            "icosahedron");
            assertThat(ofOther.code()).as(ofOther.err()).isZero();
            for (String world : List.of("spring-orbit", "icosahedron")) {
                Path saved = folder.resolve(world).resolve("later.yaml");
                assertThat(saved).content().contains("name: " + world);
                assertThat(Reve.run("check", saved.toString()).code()).isZero();
            }
            Reve.Outcome refused = control(port, "rewind", "image=never");
            assertThat(refused.code()).isEqualTo(1);
            assertThat(refused.err()).contains("no-such-image", "never");
            assertThat(control(port, "rewind", "never").code()).isEqualTo(2);
            assertThat(control(port, "shut-down").code()).isZero();
            assertThat(
                            Reve.run(
                                            "control",
                                            "shut-down",
                                            "--port",
                                            port,
                                            "--world",
                                            "icosahedron")
                                    .code())
                    .isZero();
            assertThat(server.exitCode()).isZero();
        }
    }

    @Test
    void lawsAreAskedForAndTheirParametersChangeInPlace(@TempDir Path folder) throws Exception {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        Project.WORLDS.resolve("playground").toString(),
                        "--port",
                        "0",
                        "--json")) {
            String port = server.port();
            JsonNode before = report(port, "laws").get("loaded");
            assertThat(value(before, "stiffness")).isEqualTo(2e5);
            assertThat(
                            Reve.run(
                                            "control",
                                            "set-law",
                                            "library=sphere_contact",
                                            "parameters.stiffness=12345",
                                            "--port",
                                            port)
                                    .code())
                    .isZero();
            JsonNode after = report(port, "laws").get("loaded");
            assertThat(value(after, "stiffness")).isEqualTo(12345);
            assertThat(value(after, "friction")).isEqualTo(value(before, "friction"));
            assertThat(after.findValuesAsString("library"))
                    .isEqualTo(before.findValuesAsString("library"));
            Reve.Outcome refused =
                    Reve.run(
                            "control",
                            "set-law",
                            "library=sphere_contact",
                            "parameters.stiffness=-1",
                            "--port",
                            port);
            assertThat(refused.code()).isEqualTo(1);
            assertThat(refused.err()).contains("law-refused", "stiffness");
            assertThat(value(report(port, "laws").get("loaded"), "stiffness")).isEqualTo(12345);
            assertThat(report(port, "inspect", "item=robot1").at("/physical/0/unit").asString())
                    .isEqualTo("m");
            assertThat(Reve.run("control", "inspect", "item=nobody", "--port", port).err())
                    .contains("no-such-item", "nobody");
        }
    }

    /** A vector is set as a whole, and a paused world says why a command waits. */
    @Test
    void aTextIsLoadedWithAVectorIntoAPausedWorld(@TempDir Path folder) throws Exception {
        Path wind = folder.resolve("wind.law");
        Files.writeString(
                wind,
                """
                law wind
                  parameter w = (5, 0, 0) m/s
                  each body: force += 2 kg/s * (w - velocity)
                """);
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        Project.WORLDS.resolve("sandbox").toString(),
                        "--port",
                        "0",
                        "--json")) {
            String port = server.port();
            String[] load = {"control", "load-law", "file=" + wind, "w=1,2,3", "--port", port};
            Reve.Outcome loaded = Reve.run(load);
            assertThat(loaded.code()).as(loaded.err()).isZero();
            assertThat(loaded.err()).isEmpty();
            JsonNode laws = report(port, "laws").get("loaded");
            assertThat(List.of(value(laws, "w_x"), value(laws, "w_y"), value(laws, "w_z")))
                    .containsExactly(1.0, 2.0, 3.0);
            load[3] = "w=1,2";
            assertThat(Reve.run(load).err())
                    .contains("holds [1.0,2.0] for \"w\"", "the three numbers of a vector");
            assertThat(Reve.run("control", "pause", "--port", port).code()).isZero();
            Reve.Outcome unanswered =
                    Reve.run(
                            "control",
                            "change",
                            "item=robot1",
                            "physics.mass=2",
                            "--port",
                            port,
                            "--answer-timeout",
                            "1");
            assertThat(unanswered.code()).isEqualTo(1);
            assertThat(unanswered.err())
                    .endsWith(
                            "no answer, because the world is paused; change acts in its next"
                                    + " frame\n");
            load[3] = "w=0,0,7";
            var waits = new FutureTask<>(() -> Reve.runAsProcess(load));
            Thread.ofVirtual().start(waits);
            while (value(report(port, "laws").get("loaded"), "w_z") != 7) {
                assertThat(Reve.run("control", "step", "--port", port).code()).isZero();
            }
            assertThat(waits.get().code()).isZero();
            assertThat(waits.get().err())
                    .contains("the world is paused, so load-law waits for its next frame");
        }
    }

    @Test
    void aLawOverItsBudgetIsReportedAndUnloaded(@TempDir Path folder) throws Exception {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        Project.WORLDS.resolve("icosahedron").toString(),
                        "--port",
                        "0",
                        "--json")) {
            String port = server.port();
            assertThat(setBudget(port, "newton_motion", "milliseconds=1", "then=skip-steps").err())
                    .contains("law-refused", "law newton_motion is no force law");
            assertThat(setBudget(port, "hooke_spring", "milliseconds=0").err())
                    .contains("milliseconds is 0", "expected a number from 0.001");
            assertThat(setBudget(port, "hooke_spring", "milliseconds=500", "frames=7").code())
                    .isZero();
            JsonNode springs = library(report(port, "laws"), "hooke_spring");
            assertThat(springs.at("/budget").toString())
                    .isEqualTo("{\"milliseconds\":500.0,\"frames\":7,\"then\":\"warn\"}");
            JsonNode law = springs.at("/laws/0");
            assertThat(law.get("p50Seconds").doubleValue()).isPositive();
            assertThat(law.get("p99Seconds").doubleValue())
                    .isGreaterThanOrEqualTo(law.get("p50Seconds").doubleValue());
            assertThat(law.get("share").doubleValue()).isBetween(0.0, 1.0);

            assertThat(setBudget(port, "hooke_spring", "milliseconds=0.001", "then=unload").code())
                    .isZero();
            JsonNode over = server.events().await("over-budget", event -> true);
            assertThat(over.get("library").asString()).isEqualTo("hooke_spring");
            assertThat(over.get("frames").intValue()).isEqualTo(10);
            assertThat(over.get("message").asString()).endsWith("; it is unloaded");
            assertThat(server.events().await("law-unloaded", event -> true).get("frame"))
                    .isEqualTo(over.get("frame"));
            assertThat(library(report(port, "laws"), "hooke_spring").isMissingNode()).isTrue();
            Reve.run("control", "shut-down", "--port", port);
            JsonNode end = server.events().await("end", event -> true);
            assertThat(end.at("/laws/0").has("p99Nanoseconds")).isTrue();
            assertThat(server.exitCode()).isZero();
        }
    }

    private static Reve.Outcome setBudget(String port, String library, String... fields)
            throws Exception {
        List<String> command =
                new ArrayList<>(List.of("control", "set-budget", "library=" + library));
        command.addAll(List.of(fields));
        command.addAll(List.of("--port", port));
        return Reve.run(command.toArray(String[]::new));
    }

    private static JsonNode library(JsonNode laws, String name) {
        for (JsonNode library : laws.get("loaded")) {
            if (library.get("library").asString().equals(name)) {
                return library;
            }
        }
        return MissingNode.getInstance();
    }

    private static JsonNode report(String port, String... question) throws Exception {
        List<String> command = new ArrayList<>(List.of("control"));
        command.addAll(List.of(question));
        command.addAll(List.of("--port", port));
        Reve.Outcome outcome = Reve.run(command.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private static double value(JsonNode loaded, String parameter) {
        for (JsonNode library : loaded) {
            for (JsonNode each : library.at("/laws/0/parameters")) {
                if (each.get("name").asString().equals(parameter)) {
                    return each.get("value").doubleValue();
                }
            }
        }
        throw new AssertionError("no law has the parameter " + parameter);
    }

    @Test
    void itemsAreAddedChangedAndRemovedFromFilesAndArguments(@TempDir Path folder)
            throws Exception {
        Path item =
                Files.writeString(
                        folder.resolve("item.yaml"),
                        """
                        name: moon
                        physical: {shape: sphere, radius: 20 cm, location: [3, 9, 0]}
                        physics: {mass: 200 g}
                        """);
        Path batch =
                Files.writeString(
                        folder.resolve("batch.yaml"),
                        """
                        - {t: change, item: moon, to: {name: rock}}
                        - {t: change, item: rock, to: {semantic: {class: stone}}}
                        """);
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        Project.WORLDS.resolve("spring-orbit").toString(),
                        "--port",
                        "0",
                        "--json",
                        "--saves",
                        folder.toString())) {
            String port = server.port();
            assertThat(control(port, "add", item.toString()).code()).isZero();
            Reve.Outcome again = control(port, "add", item.toString());
            assertThat(again.code()).isEqualTo(1);
            assertThat(again.err()).contains("edit-refused", "moon");
            assertThat(control(port, "change", "item=spring", "physics.end2=moon").code()).isZero();
            assertThat(control(port, "change", "item=moon", "physics.mass=2 m").err())
                    .contains("edit-refused: /physics/mass: mass: unit m does not fit kg");
            assertThat(control(port, "change", "item=moon", "physics.mass=2 kg").code()).isZero();
            assertThat(control(port, "batch", batch.toString()).code()).isZero();
            forksShowWhatWouldHappen(port, folder);
            assertThat(control(port, "rule", "name=heavy", "rule=physics.mass > 1.5").code())
                    .isZero();
            assertThat(control(port, "change", "item=rock", "semantic.mark=no. 5").code()).isZero();
            assertThat(report(port, "search", "text=5").toString()).contains("rock");
            assertThat(control(port, "rule", "name=any", "rule=true").code()).isZero();
            assertThat(control(port, "rule", "name=any", "rule=null").code()).isZero();
            assertThat(control(port, "remove", "item=blue").code()).isZero();
            assertThat(
                            control(
                                            port,
                                            "load-law",
                                            "library=sphere_contact",
                                            "parameters.friction=0.25")
                                    .code())
                    .isZero();
            assertThat(value(report(port, "laws").get("loaded"), "friction")).isEqualTo(0.25);
            assertThat(control(port, "save", "file=later").code()).isZero();
            assertThat(Files.readString(folder.resolve("later.yaml")))
                    .contains("name: rock", "end2: rock", "class: stone", "physics.mass > 1.5")
                    .doesNotContain("name: blue", "name: moon");
            assertThat(control(port, "shut-down").code()).isZero();
        }
        assertRefused(2, "'ad' is no command", "did you mean `add`?", "control", "ad");
        assertRefused(1, "there is no file", "none.yaml", "control", "add", "none.yaml");
        Path zero = Files.createSymbolicLink(folder.resolve("zero.yaml"), Path.of("/dev/zero"));
        for (String endless : List.of(zero.toString(), pipe(folder).toString())) {
            assertRefused(1, endless, "a device or a pipe", "control", "add", endless);
            assertRefused(
                    2, endless, "a device or a pipe", "control", "load-law", "file=" + endless);
        }
    }

    /** The world has the items blue and rock. A fork removes one of them in its copy only. */
    private static void forksShowWhatWouldHappen(String port, Path folder) throws Exception {
        Path changes =
                Files.writeString(folder.resolve("gone.yaml"), "- {t: remove, item: blue}\n");
        Reve.Outcome text = control(port, "fork", "frames=5");
        assertThat(text.out())
                .as(text.err())
                .matches("(?s)fork: frame \\d+, \\d+\\.\\d{3} s; locations \\[m\\]:\\R\\{.*")
                .contains("\"blue\" : [ ", "\"rock\" : [ ");
        for (String file : List.of(changes.toString(), "file=" + changes)) {
            Reve.Outcome changed = control(port, "fork", "frames=5", file);
            assertThat(changed.code()).as(changed.err()).isZero();
            assertThat(changed.out()).contains("rock").doesNotContain("blue");
        }
        JsonNode json =
                new JsonMapper().readTree(control(port, "fork", "frames=60", "--json").out());
        assertThat(json.get("frame").asLong()).isPositive();
        assertThat(json.get("time").asDouble()).isPositive();
        JsonNode rock = null;
        for (JsonNode item : json.get("items")) {
            rock = item.get("name").asString().equals("rock") ? item : rock;
        }
        assertThat(rock).isNotNull();
        assertThat(rock.get("location").size()).isEqualTo(3);
        assertThat(rock.get("orientation").size()).isEqualTo(4);
        assertThat(rock.get("symbols").get("class").asString()).isEqualTo("stone");
        assertThat(control(port, "fork", "frames=2000000").err())
                .contains("expected an integer from 0 to 1000000");
        assertThat(control(port, "fork", "frames=0.5").err())
                .contains("frames is 0.5, expected a number of frames, e.g. fork frames=60");
        assertThat(control(port, "fork").err()).contains("frames is missing");
    }

    @Test
    void whatNobodyCouldAnswerIsNotSaid() throws Exception {
        assertRefused(2, "'foresee' is no command", "rewind", "control", "foresee", "frames=3");
        assertRefused(
                2, "step has no field 'frams'", "it has frames", "control", "step", "frams=3");
        assertRefused(2, "--port is 99999", "65535", "control", "pause", "--port", "99999");
        assertRefused(
                2,
                "--answer-timeout is 0,",
                "0.1 to 3600 s",
                "control",
                "pause",
                "--answer-timeout",
                "0");
        assertRefused(
                1,
                "there is no such address",
                "nowhere.invalid",
                "control",
                "pause",
                "--host",
                "nowhere.invalid");
        assertRefused(
                1, "there is no file", "none.crt", "control", "pause", "--tls-trust", "none.crt");
        String port = closedPort();
        assertRefused(
                1,
                "127.0.0.1:" + port,
                "does a server run there?",
                "control",
                "pause",
                "--port",
                port);
    }

    @Test
    void aServerThatNeverAnswersIsReportedAfterTheTimeout() throws Exception {
        try (var silent = new ServerSocket(0, 1, InetAddress.getLoopbackAddress())) {
            assertRefused(
                    1,
                    "the server was silent for 0.3 s",
                    "is its world running?",
                    "control",
                    "pause",
                    "--port",
                    Integer.toString(silent.getLocalPort()),
                    "--answer-timeout",
                    "0.3");
        }
    }

    private static String closedPort() throws IOException {
        try (var socket = new ServerSocket(0, 1, InetAddress.getLoopbackAddress())) {
            return Integer.toString(socket.getLocalPort());
        }
    }

    private static Path pipe(Path folder) throws Exception {
        Path pipe = folder.resolve("pipe.yaml");
        assertThat(new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor()).isZero();
        return pipe;
    }

    private static void assertRefused(int code, String reason, String detail, String... command)
            throws Exception {
        Reve.Outcome outcome = Reve.run(command);
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(code);
        assertThat(outcome.err()).contains(reason, detail);
    }

    private static Reve.Outcome control(String port, String... command) throws Exception {
        String[] all = new String[command.length + 5];
        all[0] = "control";
        System.arraycopy(command, 0, all, 1, command.length);
        System.arraycopy(
                new String[] {"--port", port, "--world", "spring-orbit"},
                0,
                all,
                command.length + 1,
                4);
        return Reve.run(all);
    }
}
