// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.Join;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.RunLog;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.zip.ZipFile;

/**
 * All messages of the role control that change a world. A killed server resumes with each change,
 * and replays and packs have it.
 */
@Tag("slow")
class JournalledChangesIT {
    private static final Path PROTOCOL = Project.ROOT.resolve("agents/protocol/PROTOCOL.md");
    private static final Pattern TYPE = Pattern.compile("^\\| `([a-z-]{2,})` \\|");

    /** The laws of this world move nothing, so only messages change it. */
    private static final String WORLD =
            """
            reve: 1
            name: shelf
            laws:
              - sphere_contact
              - hooke_spring
              - text: |   # fails, because the mass of the hook is 0
                  law faulty
                    each body:
                      force += (1 kg^2*m/s^2 / mass, 0 N, 0 N)
            camera: {eye: [0, 0, 9], target: [0, 0, 0]}
            rules:
              heavy: physics.mass > 10.0
              cold: physics.mass < 0.5
              big: semantic.heavy
            items:
              - name: ball
                physical: {shape: sphere, radius: 10 cm}
                semantic: {class: toy, worn: false}
                access: {push: {effects: [{impulse: [0, 0, 1]}]}}
                physics: {mass: 1 kg}
              - {name: hook, physical: {location: [0, 2, 0]}, physics: {mass: 0}}
              - {name: nail, physical: {location: [1, 2, 0]}, physics: {mass: 0}}
              - {name: spring, kind: spring, physics: {end1: hook, end2: ball, length: 2 m}}
              - {name: sign, physical: {shape: box, size: [1, 1, 0.1], location: [0, 5, 0]}}
            """;

    /**
     * Messages that change the world, by type, in the order of the protocol. Each of them changes
     * the state of {@link #WORLD} after the messages before it.
     */
    private static final Map<String, List<Map<String, Object>>> CHANGES = changes();

    /** Messages that change nothing that a journal contains, with the reason. */
    private static final Map<String, String> OTHERS =
            new TreeMap<>(
                    Map.ofEntries(
                            Map.entry("pause", "the pace of the server"),
                            Map.entry("step", "the pace of the server"),
                            Map.entry("run", "the pace of the server"),
                            Map.entry("speed", "the pace of the server"),
                            Map.entry("snapshot", "images are in the memory of the server"),
                            Map.entry("save", "writes a file"),
                            Map.entry("picture", "writes a file"),
                            Map.entry("fork", "changes a copy"),
                            Map.entry("profile", "a question"),
                            Map.entry("changes", "a question"),
                            Map.entry("near", "a question"),
                            Map.entry("region", "a question"),
                            Map.entry("cluster", "a question"),
                            Map.entry("move-world", "an order to the cluster"),
                            Map.entry("drain-node", "an order to the cluster"),
                            Map.entry("add-world", "an order to the cluster"),
                            Map.entry("shut-down", "the end of the server")));

    private static final JsonMapper MAPPER = new JsonMapper();

    @TempDir private Path folder;
    private int saves;

    private static Map<String, Object> change(String item, Map<String, Object> to) {
        return Map.of("item", item, "to", to);
    }

    private static Map<String, Object> nothing(String key) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put(key, null);
        return fields;
    }

    private static Map<String, List<Map<String, Object>>> changes() {
        Map<String, List<Map<String, Object>>> all = new LinkedHashMap<>();
        all.put("rewind", List.of(Map.of("image", "ballast")));
        all.put(
                "edit",
                List.of(
                        Map.of("item", "ball", "property", "physics.mass", "value", 20),
                        Map.of("item", "sign", "property", "physical.colour", "value", "#123456"),
                        Map.of("item", "sign", "property", "semantic.text", "value", "stop")));
        all.put(
                "add",
                List.of(
                        Map.of(
                                "items",
                                List.of(
                                        Map.of("name", "chest {i}", "like", "box", "repeat", 2),
                                        Map.of("name", "lamp", "physics", Map.of("mass", "2 kg"))),
                                "prefabs",
                                Map.of(
                                        "box",
                                        Map.of(
                                                "physical",
                                                Map.of("shape", "box", "size", List.of(1, 2, 3)),
                                                "access",
                                                Map.of(
                                                        "open",
                                                        Map.of(
                                                                "needs",
                                                                List.of("hands"),
                                                                "when",
                                                                List.of(
                                                                        "physical.location[1] < 100.0"),
                                                                "effects",
                                                                List.of(
                                                                        Map.of(
                                                                                "symbol", "open",
                                                                                "to", true)))))))));
        all.put(
                "change",
                List.of(
                        change("lamp", Map.of("name", "lantern")),
                        change("chest 1", Map.of("parent", "hook")),
                        change(
                                "chest 0",
                                Map.of(
                                        "physical",
                                        Map.of("shape", "box", "size", List.of(2, 2, 2)))),
                        change(
                                "sign",
                                Map.of(
                                        "access",
                                        Map.of(
                                                "wipe",
                                                Map.of(
                                                        "effects",
                                                        List.of(Map.of("raise", "wiped")))))),
                        change("ball", Map.of("access", nothing("push"))),
                        change("ball", Map.of("semantic", Map.of("class", "relic"))),
                        change("ball", Map.of("semantic", nothing("worn"))),
                        change("spring", Map.of("physics", Map.of("end1", "nail"))),
                        change("lantern", nothing("physics")),
                        change("world", Map.of("physics", Map.of("gravity", List.of(0, -2, 0))))));
        all.put("remove", List.of(Map.of("item", "chest 0")));
        all.put(
                "rule",
                List.of(
                        Map.of("name", "light", "rule", "physics.mass < 1.0"),
                        Map.of("name", "heavy", "rule", Map.of("is", "physics.mass > 15.0")),
                        Map.of("name", "cold"),
                        Map.of(
                                "name",
                                "end",
                                "rule",
                                Map.of("is", "item.name", "kind", "spring"))));
        all.put(
                "batch",
                List.of(
                        Map.of(
                                "changes",
                                List.of(
                                        Map.of("t", "add", "items", List.of(Map.of("name", "cup"))),
                                        Map.of("t", "rule", "name", "end"),
                                        Map.of(
                                                "t",
                                                "rule",
                                                "name",
                                                "relic",
                                                "rule",
                                                Map.of("is", "true", "class", "relic"))))));
        all.put(
                "load-law",
                List.of(
                        Map.of("library", "drag"),
                        Map.of(
                                "library",
                                "lift.law",
                                "text",
                                "law lift\n  parameter c = 2 N\n"
                                        + "  each body: force += c * (0, 1, 0)\n",
                                "parameters",
                                Map.of("c", 3))));
        all.put(
                "set-law",
                List.of(
                        Map.of(
                                "library",
                                "sphere_contact",
                                "parameters",
                                Map.of("friction", 0.25))));
        all.put(
                "set-budget",
                List.of(
                        Map.of("library", "drag", "milliseconds", 9000, "then", "unload"),
                        Map.of("library", "sphere_contact", "milliseconds", 8000)));
        all.put("unload-law", List.of(Map.of("library", "hooke_spring")));
        all.put("release", List.of(Map.of("library", "faulty")));
        return all;
    }

    @Test
    void eachCommandOfTheProtocolIsTestedOrChangesNoWorld() throws IOException {
        Set<String> known = new TreeSet<>(CHANGES.keySet());
        known.addAll(OTHERS.keySet());
        assertThat(commands()).isEqualTo(known);
        assertThat(CHANGES.keySet()).doesNotContainAnyElementsOf(OTHERS.keySet());
    }

    /** Returns the types in the table of the commands of the role control. */
    private static Set<String> commands() throws IOException {
        String text = Files.readString(PROTOCOL);
        int begin = text.indexOf("client of the role **control**");
        int end = text.indexOf("*Queries* change nothing");
        assertThat(begin).isPositive().isLessThan(end);
        Set<String> types = new TreeSet<>();
        for (String line : text.substring(begin, end).lines().toList()) {
            Matcher type = TYPE.matcher(line);
            if (type.find()) {
                types.add(type.group(1));
            }
        }
        return types;
    }

    @Test
    void aKilledServerResumesWithAllChangesAndReplaysAndPacksHaveThem() throws Exception {
        Path world = Files.createDirectory(folder.resolve("here")).resolve("world.yaml");
        Files.writeString(world, WORLD);
        String changed;
        try (Server server = serve(1);
                AgentClient boss = control(server)) {
            changed = changeAll(boss);
            stop(boss, folder.resolve("run1.log"));
        }
        assertThat(changed).contains("lantern", "text: stop", "law lift", "relic");

        try (Server server = serve(2);
                AgentClient boss = control(server)) {
            JsonNode ready = server.events().await("ready", any -> true);
            requireReplayed(
                    folder.resolve("run1.log"), ready, "cold", "end", "heavy", "light", "relic");
            assertThat(state(boss)).isEqualTo(changed);
            // The second run begins with an image, which contains the changes of the first run.
            accepted(boss, "rule", Map.of("name", "fresh", "rule", "physics.mass > 0.0"));
            changed = state(boss);
            assertThat(changed).contains("fresh:");
            stop(boss, folder.resolve("run2.log"));
        }
        requirePacked(folder.resolve("run2.log"), changed);
        requirePacked(folder.resolve("my.db"), changed);

        // The world file still defines the rules that no message changed.
        Files.writeString(
                world, WORLD.replace("big: semantic.heavy", "big: 'true'\n  new: 1.0 + 1.0"));
        try (Server server = serve(3);
                AgentClient boss = control(server)) {
            requireReplayed(
                    folder.resolve("run2.log"),
                    server.events().await("ready", any -> true),
                    "cold",
                    "fresh",
                    "heavy",
                    "light",
                    "relic");
            accepted(boss, "pause", Map.of());
            accepted(boss, "step", Map.of("frames", 2));
            assertThat(symbols(boss, "ball"))
                    .containsEntry("heavy", true)
                    .containsEntry("light", false)
                    .containsEntry("relic", true)
                    .containsEntry("fresh", true)
                    .containsEntry("big", true)
                    .containsEntry("new", 2.0)
                    .doesNotContainKeys("cold", "end");
        }
    }

    /** Sends all messages, and returns the state of the world afterwards. */
    private String changeAll(AgentClient boss) throws Exception {
        accepted(boss, "edit", Map.of("item", "nail", "property", "semantic.old", "value", true));
        accepted(boss, "snapshot", Map.of("image", "ballast"));
        accepted(boss, "edit", Map.of("item", "nail", "property", "semantic.old", "value", false));
        String before = state(boss);
        for (Map.Entry<String, List<Map<String, Object>>> type : CHANGES.entrySet()) {
            for (Map<String, Object> fields : type.getValue()) {
                accepted(boss, type.getKey(), fields);
                String after = state(boss);
                assertThat(after).as("%s %s", type.getKey(), fields).isNotEqualTo(before);
                before = after;
            }
        }
        return before;
    }

    /** Pauses the world, and waits until its last frame is in the recording. */
    private static void stop(AgentClient boss, Path log) throws Exception {
        accepted(boss, "pause", Map.of());
        long last = accepted(boss, "step", Map.of("frames", 3));
        long recorded = -1;
        while (recorded < last) {
            Thread.onSpinWait();
            try (RunLog.Reader records = RunLog.open(log)) {
                recorded = records.lastFrame();
            }
        }
    }

    private Server serve(int run) throws Exception {
        return Server.start(
                folder,
                "serve",
                folder.resolve("here").toString(),
                "--port",
                "0",
                "--json",
                "--saves",
                folder.resolve("saved").toString(),
                "--store",
                folder.resolve("my.db").toString(),
                "--record",
                folder.resolve("run" + run + ".log").toString());
    }

    private static AgentClient control(Server server) throws Exception {
        AgentClient boss =
                Agents.join(Integer.parseInt(server.port()), Join.as("boss").withRole("control"));
        server.events().await("ready", any -> true);
        return boss;
    }

    private static long accepted(AgentClient boss, String command, Map<String, ?> fields) {
        ActResult result = boss.command(command, fields);
        assertThat(result.accepted()).as("%s %s: %s", command, fields, result).isTrue();
        return result.frame().orElseThrow();
    }

    /**
     * Returns a text of the state of the world: its world file, the symbols of its rules, and the
     * laws with what a world file does not contain.
     */
    private String state(AgentClient boss) throws Exception {
        accepted(boss, "pause", Map.of());
        accepted(boss, "step", Map.of("frames", 2));
        String file = "state" + saves++;
        accepted(boss, "save", Map.of("file", file));
        List<Object> rest = new ArrayList<>();
        for (String item : List.of("ball", "hook", "spring")) {
            rest.add(new TreeMap<>(symbols(boss, item)));
        }
        JsonNode laws = MAPPER.valueToTree(boss.report("laws", Map.of()).content());
        for (JsonNode library : laws.path("loaded")) {
            rest.add(library.path("library") + " " + library.path("sha256"));
            rest.add(library.path("budget"));
        }
        laws.path("quarantined").forEach(library -> rest.add(library.path("library")));
        accepted(boss, "run", Map.of());
        return timeless(Files.readString(folder.resolve("saved").resolve(file + ".yaml"))) + rest;
    }

    @SuppressWarnings("unchecked") // the protocol says that it is an object
    private static Map<String, Object> symbols(AgentClient boss, String item) {
        return (Map<String, Object>)
                boss.report("inspect", Map.of("item", item)).content().get("semantic");
    }

    private static String timeless(String world) {
        return world.replaceAll("age: \\d+", "age: 0");
    }

    /** The recording is repeated to the bits of the resumed world. */
    private static void requireReplayed(Path log, JsonNode ready, String... rules)
            throws Exception {
        Outcome replay =
                Reve.run(
                        "replay",
                        log.toString(),
                        "--json",
                        "--until",
                        ready.path("frame").asString());
        assertThat(replay.code()).as(replay.err()).isZero();
        JsonNode result = MAPPER.readTree(replay.out());
        assertThat(result.path("identical").asBoolean()).isTrue();
        assertThat(result.path("frame").asLong()).isEqualTo(ready.path("frame").asLong());
        assertThat(result.path("stateHash").asString())
                .isEqualTo(ready.path("stateHash").asString());
        assertThat(result.path("changedRules"))
                .extracting(JsonNode::asString)
                .containsExactly(rules);
    }

    private void requirePacked(Path run, String state) throws Exception {
        Path pack = folder.resolve(run.getFileName() + ".reve");
        Outcome made = Reve.run("pack", run.toString(), "--out", pack.toString());
        assertThat(made.code()).as(made.err()).isZero();
        try (ZipFile zip = new ZipFile(pack.toFile());
                InputStream in = zip.getInputStream(zip.getEntry("world.yaml"))) {
            String world = new String(in.readAllBytes(), StandardCharsets.UTF_8);
            assertThat(state).as("%s", pack).startsWith(timeless(world));
        }
    }
}
