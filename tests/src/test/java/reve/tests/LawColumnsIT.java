// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.concurrent.TimeUnit;

/** Columns that laws have of their own, in the report of an item. */
@Tag("slow")
class LawColumnsIT {
    private static final JsonMapper MAPPER = new JsonMapper();
    private static final int RATE = 60;

    private static final String WORLD =
            """
            reve: 1
            name: kiln
            frame: {rate: 60, steps: 1}
            laws: [surface_contact, rigid_contact, heat, odometer]
            items:
              - {name: first, physical: {location: [0, 0, 0]}, physics: {mass: 1}}
              - {name: ball, physical: {location: [5, 0, 0]}, physics: {mass: 1, velocity: [3, 0, 0]}}
              - {name: last, physical: {location: [0, 9, 0]}, physics: {mass: 1, velocity: [0, 0, 2]}}
              - {name: rope, kind: spring, physics: {end1: ball, end2: last, length: 1 m}}
              - {name: sign, physical: {shape: box, size: [1, 1, 1], location: [9, 9, 9]}}
            """;

    private static final String HEAT =
            """
            law heat "Heats all bodies, and wears all springs."
              each body has warmth in J, from 0 J, turns
              each spring has wear in m
              each body: warmth += 2 W dt; turns += 1
              each spring: wear += 0.5 m/s dt
            """;

    private static final String ODOMETER =
            """
            import vesper


            @vesper.law(phase="observe")
            def odometer(
                velocity: vesper.Read("body", "m/s"),
                path: vesper.Scratch("body", "m", components=3),
                dt,
            ):
                path += velocity * dt
            """;

    @TempDir private Path folder;

    @BeforeEach
    void write() throws Exception {
        Files.writeString(folder.resolve("kiln.yaml"), WORLD);
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Files.writeString(laws.resolve("heat.law"), HEAT);
        Files.writeString(laws.resolve("odometer.py"), ODOMETER);
    }

    private Server serve(String... options) throws Exception {
        List<String> all =
                new ArrayList<>(
                        List.of(
                                "serve",
                                folder.resolve("kiln.yaml").toString(),
                                "--laws",
                                folder.resolve("laws").toString(),
                                "--port",
                                "0",
                                "--json"));
        all.addAll(List.of(options));
        return Server.start(folder, all.toArray(String[]::new));
    }

    private static JsonNode control(Server server, String... words) throws Exception {
        List<String> all = new ArrayList<>(List.of("control"));
        all.addAll(List.of(words));
        all.addAll(List.of("--port", server.port(), "--json"));
        Outcome done = Reve.run(all.toArray(String[]::new));
        assertThat(done.code()).as(done.err()).isZero();
        return done.out().startsWith("{") ? MAPPER.readTree(done.out()) : MAPPER.createObjectNode();
    }

    /** Lets the world make some frames, and waits until it is paused after the last one. */
    private static void pause(AgentClient boss) {
        assertThat(boss.command("pause", Map.of()).accepted()).isTrue();
        long last = boss.command("step", Map.of("frames", RATE / 2)).frame().orElseThrow();
        while (boss.report("inspect", Map.of("item", "world")).frame() < last) {
            Thread.onSpinWait();
        }
    }

    private static JsonNode column(JsonNode report, String law, String name) {
        for (JsonNode column : report.path("lawColumns")) {
            if (column.path("law").asString().equals(law)
                    && column.path("name").asString().equals(name)) {
                return column;
            }
        }
        throw new AssertionError("no column " + name + " of " + law + " in " + report);
    }

    @Test
    void textsLibrariesAndPythonShowTheColumnsThatTheyBrought() throws Exception {
        try (Server server = serve();
                AgentClient boss = client(server)) {
            pause(boss);
            var answer = boss.report("inspect", Map.of("item", "ball"));
            double seconds = (double) answer.frame() / RATE;
            JsonNode ball = MAPPER.valueToTree(answer.content());
            JsonNode warmth = column(ball, "heat", "warmth");
            assertThat(warmth.path("library").asString()).isEqualTo("heat");
            assertThat(warmth.path("unit").asString()).isEqualTo("J");
            assertThat(warmth.path("value").asDouble()).isCloseTo(2 * seconds, within(1e-9));
            JsonNode turns = column(ball, "heat", "turns");
            assertThat(turns.path("value").asDouble()).isEqualTo(answer.frame());
            assertThat(turns.path("unit").asString()).isEqualTo("1");
            JsonNode path = column(ball, "odometer", "path");
            assertThat(path.path("unit").asString()).isEqualTo("m");
            assertThat(path.path("value").get(0).asDouble()).isCloseTo(3 * seconds, within(1e-9));
            assertThat(path.path("value").get(1).asDouble()).isZero();
            assertThat(path.has("components")).isFalse();
            assertThat(column(ball, "surface_contact", "frictionUse").path("value")).hasSize(2);
            JsonNode places = column(ball, "rigid_contact", "places");
            assertThat(places.path("value")).hasSize(64);
            assertThat(places.path("components").asInt()).isEqualTo(96);
            assertThat(ball.has("moreLawColumns")).isFalse();

            JsonNode rope = MAPPER.valueToTree(inspect(boss, "rope"));
            assertThat(rope.path("lawColumns")).hasSize(1);
            assertThat(column(rope, "heat", "wear").path("value").asDouble())
                    .isCloseTo(0.5 * seconds, within(1e-9));
            for (String item : List.of("sign", "world")) {
                assertThat(inspect(boss, item)).doesNotContainKey("lawColumns");
            }

            // The command and Python show the same.
            String shown = ball.path("lawColumns").toString();
            assertThat(control(server, "inspect", "item=ball").path("lawColumns").toString())
                    .isEqualTo(shown);
            assertThat(fromPython(server.port()).toString()).isEqualTo(shown);
        }
    }

    @Test
    void theColumnsStayWithTheItemAndGoWithTheLaw() throws Exception {
        try (Server server = serve();
                AgentClient boss = client(server)) {
            pause(boss);
            control(server, "run");
            assertThat(boss.command("remove", Map.of("item", "first")).accepted()).isTrue();
            var added = boss.command("add", Map.of("items", List.of(item("late"))));
            assertThat(added.accepted()).isTrue();
            pause(boss);
            var answer = boss.report("inspect", Map.of("item", "last"));
            JsonNode last = MAPPER.valueToTree(answer.content());
            double seconds = (double) answer.frame() / RATE;
            // The last body has taken the row of the first one.
            assertThat(column(last, "odometer", "path").path("value").get(2).asDouble())
                    .isCloseTo(2 * seconds, within(1e-9));
            double since = (answer.frame() - added.frame().orElseThrow() + 1.0) / RATE;
            JsonNode late = MAPPER.valueToTree(inspect(boss, "late"));
            assertThat(column(late, "heat", "warmth").path("value").asDouble())
                    .isCloseTo(2 * since, within(1e-9));

            control(server, "run");
            assertThat(boss.command("unload-law", Map.of("library", "heat")).accepted()).isTrue();
            assertThat(inspect(boss, "last").toString()).doesNotContain("warmth");
            assertThat(inspect(boss, "rope")).doesNotContainKey("lawColumns");
        }
    }

    /** Four laws with 200 vectors each have more values than a report reads. */
    @Test
    void aReportNamesTheNumberOfColumnsThatItOmits() throws Exception {
        StringBuilder text = new StringBuilder();
        for (int law = 0; law < 4; law++) {
            text.append("law archive").append(law).append('\n');
            for (int i = 0; i < 200; i++) {
                text.append("  each body has a vector v").append(i).append(" in m\n");
            }
            text.append("  each body:\n");
            for (int i = 0; i < 200; i++) {
                text.append("    v").append(i).append(" = (1, 2, ").append(i).append(") m\n");
            }
        }
        try (Server server = serve();
                AgentClient boss = client(server)) {
            Map<String, Object> load = Map.of("library", "archive.law", "text", text.toString());
            var loaded = boss.command("load-law", load);
            assertThat(loaded.accepted()).as("%s", loaded).isTrue();
            pause(boss);
            JsonNode ball = MAPPER.valueToTree(inspect(boss, "ball"));
            assertThat(column(ball, "archive1", "v199").path("value").toString())
                    .isEqualTo("[1.0,2.0,199.0]");
            int shown = ball.path("lawColumns").size();
            int before = 2 + 5 + 2 + 1; // of the laws of the world
            assertThat(shown).isBetween(before + 400, before + 600);
            assertThat(shown + ball.path("moreLawColumns").asInt()).isEqualTo(before + 800);
        }
    }

    @Test
    void thePanelOfItemsShowsThem() throws Exception {
        Path profile = Files.createDirectory(folder.resolve("profile"));
        try (Server server = serve("--web", "0");
                var browser = new Browser(profile, 1360, 820)) {
            JsonNode ready = server.events().await("ready", any -> true);
            browser.open(ready.get("web").asString());
            browser.await("document.body.dataset.state === 'open' && reve.view.frame > 0");
            browser.ask("reve.select(reve.view.byName.get('ball').slot)");
            browser.await("document.querySelector('#law-columns')");
            String warmth =
                    "[...document.querySelectorAll('#law-columns tr')].find(r =>"
                            + " r.firstChild.textContent === 'warmth')";
            browser.await(warmth + ".children[1].textContent > 0");
            assertThat(browser.ask(warmth + ".children[2].textContent").asString()).isEqualTo("J");
            assertThat(browser.ask(warmth + ".children[3].textContent").asString())
                    .isEqualTo("heat");
            String before = browser.ask(warmth + ".children[1].textContent").asString();
            browser.await(warmth + ".children[1].textContent !== '" + before + "'");
            assertThat(browser.text("#aspects")).contains("Columns of laws", "rigid_contact");
            browser.picture(Project.ROOT.resolve("build/reports/page/law-columns.png"));
            browser.ask("reve.select(reve.view.byName.get('sign').slot)");
            browser.await("document.querySelector('#item-name').textContent === 'sign'");
            browser.await("!document.querySelector('#law-columns')");
        }
    }

    private static Map<String, Object> item(String name) {
        return Map.of(
                "name",
                name,
                "physical",
                Map.of("location", List.of(0, 30, 0)),
                "physics",
                Map.of("mass", 1));
    }

    private static AgentClient client(Server server) throws Exception {
        return Agents.join(Integer.parseInt(server.port()), Join.as("boss").withRole("control"));
    }

    private static Map<String, Object> inspect(AgentClient boss, String item) {
        return boss.report("inspect", Map.of("item", item)).content();
    }

    private JsonNode fromPython(String port) throws Exception {
        Path script =
                Files.writeString(
                        folder.resolve("inspect_ball.py"),
                        """
                        import json, sys
                        import reve

                        with reve.control("127.0.0.1", int(sys.argv[1]), name="snake") as boss:
                            print(json.dumps(boss.inspect("ball").content["lawColumns"]))
                        """);
        ProcessBuilder builder = new ProcessBuilder("python3", script.toString(), port);
        builder.environment().put("PYTHONPATH", Project.ROOT.resolve("agents/python").toString());
        builder.redirectError(folder.resolve("python.err").toFile());
        Process python = builder.start();
        String said = new String(python.getInputStream().readAllBytes());
        assertThat(python.waitFor(300, TimeUnit.SECONDS)).isTrue();
        assertThat(python.exitValue()).as(Files.readString(folder.resolve("python.err"))).isZero();
        return MAPPER.readTree(said);
    }
}
