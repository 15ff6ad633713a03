// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.Perception;
import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** Plugins in Java, at the commands that load them. */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class PluginsIT {
    /** Adds one to the charge of the item a, in each frame. */
    private static final String COUNTER =
            """
            import reve.core.frame.*;
            import reve.core.world.*;
            public final class Counter implements FrameListenerProvider {
                public String name() { return "test.counter"; }
                public String doc() { return "Counts frames."; }
                public FrameListener listen(World world) {
                    return frame -> {
                        PhysicsAspect a = frame.world().find("a").orElseThrow().physics();
                        a.set("charge", a.scalar("charge") + 1);
                    };
                }
            }
            """;

    /** Throws in frame 5. */
    private static final String FAILING =
            """
            import reve.core.frame.*;
            import reve.core.world.*;
            public final class Failing implements FrameListenerProvider {
                public String name() { return "test.failing"; }
                public String doc() { return ""; }
                public FrameListener listen(World world) {
                    return frame -> {
                        Item b = frame.world().find("b").orElseThrow();
                        b.physics().set("charge", frame.frame());
                        if (frame.frame() >= 5) {
                            throw new IllegalStateException("no more");
                        }
                    };
                }
            }
            """;

    private static final String WORLD =
            """
            reve: 1
            name: counted
            laws: [newton_motion]
            agents: {bodies: [b]}
            items:
              - {name: a, physical: {location: [0, 0, 0]}, physics: {mass: 1 kg, velocity: [1, 0, 0]}}
              - {name: b, physical: {location: [1, 0, 0]}, physics: {mass: 1 kg}}
            """;

    @TempDir private Path folder;
    private Path plugins;
    private Path world;

    @BeforeEach
    void writeWorld() throws IOException {
        plugins = Files.createDirectory(folder.resolve("plugins"));
        world = Files.writeString(folder.resolve("world.yaml"), WORLD);
    }

    private PluginJar jar() throws IOException {
        return new PluginJar(folder);
    }

    private Outcome run(String... more) throws Exception {
        List<String> command = new ArrayList<>(List.of("run", world.toString()));
        command.addAll(List.of(more));
        return Reve.run(command.toArray(String[]::new));
    }

    private static JsonNode json(Outcome outcome) {
        return new JsonMapper().readTree(outcome.out());
    }

    private void refused(String... messages) throws Exception {
        Outcome outcome = Reve.run("check", world.toString(), "--plugins", plugins.toString());
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(2);
        assertThat(outcome.out()).isEmpty();
        assertThat(outcome.err()).contains(messages);
    }

    @Test
    void theExampleOfThePageRuns() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/plugins.md"));
        Files.createDirectory(folder.resolve("example"));
        for (String source : List.of("Unlock", "Compass", "Facing", "Openings")) {
            Files.writeString(
                    folder.resolve("example/" + source + ".java"),
                    page.titled(source + ".java").text());
        }
        Files.writeString(folder.resolve("house.yaml"), page.titled("house.yaml").text());
        var shell = new Shell(folder);
        String bin = System.getProperty("java.home") + "/bin";
        shell.run("PATH=\"" + bin + ":$PATH\"\n" + page.titled("build.sh").text());

        try (Server server = shell.serve("exec " + page.titled("serve.sh").text())) {
            Files.writeString(
                    folder.resolve("visit.py"),
                    page.titled("visit.py").text().replace("7777", server.port()));
            assertThat(shell.run("PYTHONPATH=\"$REVE/agents/python\" python3 visit.py"))
                    .isEqualTo(page.titled("printed").text());
            JsonNode ready = server.events().await("ready", event -> true);
            assertThat(ready.path("plugins").path(0).asString())
                    .matches("house\\.jar \\(SHA-256 [0-9a-f]{12}…\\)");
            server.process().toHandle().destroy();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }

        String log = folder.resolve("house.log").toString();
        Outcome replay = Reve.run("replay", log, "--plugins", plugins.toString());
        assertThat(replay.code()).as(replay.err()).isZero();
        assertThat(replay.out()).startsWith("identical: ");
        assertThat(replay.err()).doesNotContain("plugin");

        Outcome without = Reve.run("replay", log);
        assertThat(without.code()).as(without.out()).isEqualTo(1);
        assertThat(without.err())
                .contains("there is no action `example.unlock`", "the plugin house.jar (SHA-256 ")
                .contains("is missing; name its folder with --plugins");

        Outcome check = Reve.run("check", folder.resolve("house.yaml").toString());
        assertThat(check.code()).isEqualTo(3);
        assertThat(check.err())
                .contains(
                        "house.yaml:4:18: java: there is no symbol `example.facing`",
                        "house.yaml:10:23: java: there is no sensor `example.compass`",
                        "house.yaml:16:22: java: there is no action `example.unlock`");
    }

    @Test
    void aReplayRepeatsTheChangesOfAListenerWithoutIt() throws Exception {
        jar().with(PluginJar.LISTENER, COUNTER).version("1.2").write(plugins.resolve("count.jar"));
        String log = folder.resolve("run.log").toString();
        Path saved = folder.resolve("saved.yaml");
        String dir = plugins.toString();

        Outcome plain = run("--seconds", "1", "--json");
        Outcome counted =
                run(
                        "--seconds",
                        "1",
                        "--json",
                        "--plugins",
                        dir,
                        "--record",
                        log,
                        "--save",
                        saved.toString());
        assertThat(counted.code()).as(counted.err()).isZero();
        assertThat(Files.readString(saved)).contains("charge: 60");
        assertThat(json(counted).path("stateHash")).isNotEqualTo(json(plain).path("stateHash"));

        Outcome missing = Reve.run("replay", log, "--json");
        assertThat(missing.code()).as(missing.err()).isZero();
        assertThat(json(missing).path("identical").asBoolean()).isTrue();
        assertThat(json(missing).path("stateHash")).isEqualTo(json(counted).path("stateHash"));
        assertThat(json(missing).path("missingPlugins").path(0).asString())
                .startsWith("the plugin count.jar 1.2 (SHA-256 ")
                .endsWith(" is missing; name its folder with --plugins");
        Outcome present = Reve.run("replay", log, "--plugins", dir, "--json");
        assertThat(json(present).path("stateHash")).isEqualTo(json(counted).path("stateHash"));
        assertThat(json(present).has("missingPlugins")).isFalse();
        jar().with(PluginJar.LISTENER, COUNTER).version("1.3").write(plugins.resolve("count.jar"));
        Outcome changed = Reve.run("replay", log, "--plugins", dir);
        assertThat(changed.code()).as(changed.err()).isZero();
        assertThat(changed.err()).contains("has changed, it is now count.jar 1.3 (SHA-256 ");
    }

    /** The charge is the number of the frame, also after the world was resumed. */
    @Test
    void aListenerOfAResumedWorldIsCalledOnceInEachFrame() throws Exception {
        jar().with(PluginJar.LISTENER, COUNTER).write(plugins.resolve("count.jar"));
        Path store = folder.resolve("counted.db");
        String[] serve = {
            "serve",
            world.toString(),
            "--port",
            "0",
            "--fast",
            "--seconds",
            "1",
            "--store",
            store.toString(),
            "--plugins",
            plugins.toString()
        };
        for (int i = 0; i < 2; i++) {
            Outcome served = Reve.run(serve);
            assertThat(served.code()).as(served.err()).isZero();
        }
        Path tables = folder.resolve("tables");
        Outcome export = Reve.run("export", store.toString(), "--csv", tables.toString());
        assertThat(export.code()).as(export.err()).isZero();
        List<String> rows = Files.readAllLines(tables.resolve("body.csv"));
        List<String> names = List.of(rows.getFirst().split(","));
        int frame = names.indexOf("frame");
        int charge = names.indexOf("charge [C]");
        int name = names.indexOf("item");
        long compared = 0;
        double last = 0;
        for (String row : rows.subList(1, rows.size())) {
            String[] values = row.split(",");
            if (values[name].equals("a")) {
                last = Double.parseDouble(values[charge]);
                assertThat(last).isEqualTo(Double.parseDouble(values[frame]));
                compared++;
            }
        }
        assertThat(compared).isPositive();
        assertThat(last).isEqualTo(120);
    }

    @Test
    void aPluginThatThrowsCostsOnlyItself() throws Exception {
        jar().with(PluginJar.LISTENER, COUNTER).write(plugins.resolve("count.jar"));
        jar().with(PluginJar.LISTENER, FAILING)
                .with(
                        PluginJar.LISTENER,
                        """
                        import java.util.Map;
                        import reve.core.frame.*;
                        import reve.core.world.*;
                        public final class Forger implements FrameListenerProvider {
                            public String name() { return "test.forger"; }
                            public String doc() { return ""; }
                            public FrameListener listen(World world) {
                                return event -> event.world().raise(
                                    new WorldEvent(event.frame(), "joined", Map.of("agent", "root")));
                            }
                        }
                        """)
                .with(
                        PluginJar.ACTION,
                        """
                        import java.util.List;
                        import reve.core.access.*;
                        import reve.core.world.*;
                        public final class Fall implements ActionProvider {
                            public String name() { return "test.fall"; }
                            public String doc() { return ""; }
                            public List<Effect> decide(ActionCall call) {
                                Thread.currentThread().interrupt();
                                throw new Error("fell");
                            }
                        }
                        """)
                .with(
                        PluginJar.SYMBOL,
                        """
                        import java.util.Optional;
                        import reve.core.world.*;
                        public final class Half implements SymbolProvider {
                            public String name() { return "test.half"; }
                            public String doc() { return ""; }
                            public Optional<Object> value(Item item) {
                                if (item.name().equals("b")) {
                                    throw new UnsupportedOperationException("not b");
                                }
                                return Optional.of(true);
                            }
                        }
                        """)
                .with(
                        PluginJar.SENSOR,
                        """
                        import java.util.List;
                        import reve.core.unit.Unit;
                        import reve.core.world.*;
                        public final class Odd implements SensorProvider {
                            public String name() { return "test.odd"; }
                            public String doc() { return ""; }
                            public List<Quantity> quantities() {
                                return List.of(new Quantity("x", 1, Unit.parse("m")));
                            }
                            public void measure(Item body, double timeSeconds, double[] numbers) {
                                if (timeSeconds > 1) {
                                    numbers[0] = Double.NaN;
                                }
                            }
                        }
                        """)
                .write(plugins.resolve("bad.jar"));
        Files.writeString(
                world,
                """
                reve: 1
                name: counted
                laws: [newton_motion]
                rules: {half: {java: test.half}}
                agents: {bodies: [b]}
                items:
                  - name: a
                    physical: {location: [0, 0, 0]}
                    physics: {mass: 1 kg}
                    access: {fall: {java: test.fall}}
                  - name: b
                    physical: {location: [1, 0, 0]}
                    physics: {mass: 1 kg}
                    sensors: {eyes: {}, odd: {java: test.odd}}
                """);
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        world.toString(),
                        "--port",
                        "0",
                        "--json",
                        "--plugins",
                        plugins.toString())) {
            fault(
                    server,
                    "listener test.forger",
                    "plug.Forger",
                    "a listener must not raise the event joined, which the server raises itself");
            fault(server, "listener test.failing", "plug.Failing", "no more; it is not called");
            fault(server, "rule half", "plug.Half", "not b; b has no half");
            fault(server, "sensor test.odd", "plug.Odd", "it measured NaN, expected finite");
            try (AgentClient agent = Agents.join(Integer.parseInt(server.port()), "ada")) {
                ActResult result = agent.act("a", "fall", Map.of());
                assertThat(result.code()).contains("action-failed");
                JsonNode fell = fault(server, "action test.fall", "plug.Fall", "fell; the act was");
                assertThat(agent.act("a", "fall", Map.of()).code()).contains("action-failed");
                Perception perception = agent.perceive();
                assertThat(symbols(perception, "a")).containsEntry("half", true);
                assertThat(symbols(perception, "b")).doesNotContainKey("half");
                assertThat(perception.readings()).doesNotContainKey("odd");
                assertThat(perception.frame()).isGreaterThan(fell.path("frame").asLong());
            }
            server.process().toHandle().destroy();
            List<JsonNode> events = server.events().untilEnd();
            assertThat(server.exitCode()).isZero();
            assertThat(events)
                    .filteredOn(event -> event.path("event").asString().equals("fault"))
                    .as("each is reported once")
                    .hasSize(5);
        }
        Outcome run =
                Reve.runAsProcess(
                        "run",
                        world.toString(),
                        "--seconds",
                        "1",
                        "--plugins",
                        plugins.toString(),
                        "--save",
                        folder.resolve("end.yaml").toString());
        assertThat(run.err())
                .as("the log has the place of the exception")
                .contains("no more at bad.jar//plug.Failing.");
        assertThat(Files.readString(folder.resolve("end.yaml")))
                .as("the other listener goes on, the failed one is not called again")
                .contains("charge: 60", "charge: 5");
    }

    private static Map<String, Object> symbols(Perception perception, String item) {
        return perception.find(item).orElseThrow().symbols();
    }

    private static JsonNode fault(Server server, String source, String type, String message)
            throws IOException {
        JsonNode fault =
                server.events()
                        .await("fault", event -> event.path("source").asString().equals(source));
        assertThat(fault.path("plugin").asString()).isEqualTo("bad.jar");
        assertThat(fault.path("class").asString()).isEqualTo(type);
        assertThat(fault.path("message").asString()).startsWith(message);
        return fault;
    }

    @Test
    void aSlowPluginIsNamedByTheWatchdog() throws Exception {
        Path slow = Files.createFile(folder.resolve("slow"));
        jar().with(
                        PluginJar.LISTENER,
                        """
                        import java.nio.file.*;
                        import reve.core.frame.*;
                        import reve.core.world.World;
                        public final class Slow implements FrameListenerProvider {
                            public String name() { return "test.slow"; }
                            public String doc() { return ""; }
                            public FrameListener listen(World world) {
                                return frame -> {
                                    while (frame.frame() == 3 && Files.exists(Path.of("%s"))) {
                                        Thread.onSpinWait();
                                    }
                                };
                            }
                        }
                        """
                                .formatted(slow))
                .write(plugins.resolve("slow.jar"));
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        world.toString(),
                        "--port",
                        "0",
                        "--json",
                        "--watchdog",
                        "0.5",
                        "--plugins",
                        plugins.toString())) {
            JsonNode stalled =
                    server.events().await("stalled", event -> event.path("frame").asLong() == 3);
            assertThat(stalled.path("phase").asString()).isEqualTo("ACT");
            assertThat(stalled.path("activity").asString()).isEqualTo("listener test.slow");
            assertThat(stalled.path("stack").toString()).contains("plug.Slow");
            Files.delete(slow);
            server.events().await("recovered", event -> true);
        }
    }

    @Test
    void jarsThatCannotBeUsedAreNamed() throws Exception {
        refused("reve: plugins folder " + plugins + " has no file that ends in .jar");
        Files.writeString(plugins.resolve("README.txt"), "not a plugin");
        Path jar = plugins.resolve("count.jar");

        Files.writeString(jar, "PK no jar");
        refused("reve: " + jar + " cannot be read as a jar: ", "; build it again");

        jar().withoutClass("java.lang.Runnable", "plug.Counter").write(jar);
        refused("reve: " + jar + " provides nothing; expected one of the files META-INF/services/");

        jar().withoutClass(PluginJar.LISTENER, "plug.Missing").write(jar);
        refused("reve: " + jar + ": its listener cannot be created: ", "plug.Missing not found");

        jar().withoutClass(PluginJar.LISTENER, "reve.core.world.World").write(jar);
        refused("reve: " + jar);

        jar().with(PluginJar.LISTENER, COUNTER).write(jar, 99);
        refused("reve: " + jar + " was compiled for a newer Java: ", "class file version 99.0");

        jar().with(
                        PluginJar.LISTENER,
                        COUNTER.replace("public String doc", "Counter() {}\npublic String doc"))
                .write(jar);
        refused("reve: " + jar + ": its listener cannot be created: ");

        jar().with(
                        PluginJar.LISTENER,
                        COUNTER.replace(
                                "public String doc",
                                "public Counter() { throw new IllegalStateException(\"no key\"); }\n"
                                        + "public String doc"))
                .write(jar);
        refused("reve: " + jar, "java.lang.IllegalStateException: no key");

        jar().with(PluginJar.SYMBOL, COUNTER).write(jar);
        refused("reve: " + jar + ": its symbol cannot be created: ", "plug.Counter");
    }

    @Test
    void twoPluginsWithOneNameAreNamed() throws Exception {
        Path first = jar().with(PluginJar.LISTENER, COUNTER).write(plugins.resolve("a.jar"));
        Path second = jar().with(PluginJar.LISTENER, COUNTER).write(plugins.resolve("b.jar"));
        refused(
                "reve: "
                        + second
                        + ": the listener test.counter is also in "
                        + first
                        + "; remove one of the jars");
    }

    @Test
    void aFolderOrJarThatEveryUserMayWriteIsRefused() throws Exception {
        Path jar = jar().with(PluginJar.LISTENER, COUNTER).write(plugins.resolve("count.jar"));
        Files.setPosixFilePermissions(jar, PosixFilePermissions.fromString("rw-rw-rw-"));
        refused("reve: " + jar + " can be written by every user");
        Files.setPosixFilePermissions(jar, PosixFilePermissions.fromString("rw-r--r--"));
        Path real = Files.move(jar, folder.resolve("real.jar"));
        Files.createSymbolicLink(jar, real);
        refused("reve: " + jar + " is not a regular file; copy the jar into the folder");
        Files.delete(jar);
        Files.move(real, jar);
        Files.setPosixFilePermissions(plugins, PosixFilePermissions.fromString("rwxrwxrwx"));
        refused("reve: plugins folder " + plugins + " can be written by every user");
        Files.setPosixFilePermissions(plugins, PosixFilePermissions.fromString("rwxr-xr-x"));
        Outcome right = Reve.run("check", world.toString(), "--plugins", plugins.toString());
        assertThat(right.code()).as(right.err()).isZero();
        Outcome none = Reve.run("check", world.toString(), "--plugins", folder + "/none");
        assertThat(none.code()).isEqualTo(2);
        assertThat(none.err()).contains("none is not a folder");
    }

    /** A class of a plugin would create a file as soon as it is loaded. */
    @Test
    void jarsThatComeWithAWorldAreNeverOpened() throws Exception {
        Path touched = folder.resolve("touched");
        String greedy =
                COUNTER.replace(
                        "public String name()",
                        "static { new java.io.File(\""
                                + touched
                                + "\").mkdir(); }\n"
                                + "public String name()");
        for (String place : List.of("plugins", "laws", "lib", ".")) {
            jar().with(PluginJar.LISTENER, greedy).write(folder.resolve(place + "/count.jar"));
        }
        Outcome run = run("--seconds", "0.1", "--trust", "--json");
        assertThat(run.code()).as(run.err()).isZero();
        Path pack = folder.resolve("counted.reve");
        Outcome packed = Reve.run("pack", folder.toString(), "--out", pack.toString());
        assertThat(packed.code()).as(packed.err()).isZero();
        Outcome check = Reve.run("check", pack.toString(), "--trust");
        assertThat(check.code()).as(check.err()).isZero();
        assertThat(touched).doesNotExist();

        Outcome asked = run("--seconds", "0.1", "--plugins", plugins.toString());
        assertThat(asked.code()).as(asked.err()).isZero();
        assertThat(touched).as("the test would notice a class that is loaded").exists();
    }
}
