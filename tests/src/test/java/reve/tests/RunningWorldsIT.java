// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.core.frame.FrameLoop;
import reve.core.world.AccessAspect;
import reve.core.world.Forces;
import reve.core.world.PhysicalAspect;
import reve.core.world.PhysicsAspect;
import reve.core.world.SemanticAspect;
import reve.core.world.World;
import reve.pe.adapter.Laws;
import reve.pe.adapter.PhysicsAdapter;
import reve.worlds.server.Simulation;

import tools.jackson.databind.json.JsonMapper;

import java.lang.reflect.Method;
import java.lang.reflect.Modifier;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeSet;
import java.util.concurrent.TimeUnit;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** The tables of docs/running-worlds.md. Each cell works, and no operation of Java is missing. */
@Tag("slow")
class RunningWorldsIT {
    private static final Path PAGE = Project.ROOT.resolve("docs/running-worlds.md");
    private static final Pattern CODE = Pattern.compile("`([^`]+)`");
    private static final Pattern FILE =
            Pattern.compile("```yaml\n# (\\w+\\.yaml)\n(.*?)```", Pattern.DOTALL);

    /** Classes whose operations the page lists. */
    private static final List<Class<?>> DOORS =
            List.of(
                    World.class,
                    Forces.class,
                    PhysicalAspect.class,
                    SemanticAspect.class,
                    AccessAspect.class,
                    PhysicsAspect.class,
                    Laws.class,
                    PhysicsAdapter.class,
                    Simulation.class,
                    FrameLoop.class);

    private static final Pattern OPERATION =
            Pattern.compile(
                    "(add|remove|rename|attach|detach|set|clear|load|unload|release|keep|rewind"
                            + "|fork|pause|resume|stop)([A-Z].*)?");

    /** Classes of whose operations the name says nothing: each method without a result is one. */
    private static final Set<Class<?>> WHOLE =
            Set.of(
                    World.class,
                    Forces.class,
                    PhysicalAspect.class,
                    SemanticAspect.class,
                    AccessAspect.class,
                    PhysicsAspect.class);

    private static final String BUILDS = "is for programs that build or restore a world";
    private static final String CHECKS = "throws an exception or does nothing";
    private static final String RULES = "belongs to the rules of a world, which compute symbols";

    /** Operations that the page does not list, each with the reason. */
    private static final Map<String, String> UNLISTED =
            Map.ofEntries(
                    Map.entry("FrameLoop.setGate", BUILDS),
                    Map.entry("World.setAge", BUILDS),
                    Map.entry("World.restore", BUILDS),
                    Map.entry("World.restoreName", BUILDS),
                    Map.entry("SemanticAspect.restore", BUILDS),
                    Map.entry("World.add", "is addAll with one item"),
                    Map.entry("World.requireAddable", CHECKS),
                    Map.entry("World.requireRemovable", CHECKS),
                    Map.entry("World.requireAttachable", CHECKS),
                    Map.entry("World.raise", "reports what happened and changes no item"),
                    Map.entry("SemanticAspect.derive", RULES),
                    Map.entry("SemanticAspect.dropDerived", RULES),
                    Map.entry("Laws.addListener", BUILDS),
                    Map.entry("Laws.keepPreviousFor", BUILDS),
                    Map.entry("Laws.removeListener", BUILDS));

    /** Messages that the server answers with a report. */
    private static final Set<String> REPORTS =
            Set.of("state", "inspect", "search", "laws", "ledger");

    /**
     * A row of a table. It has the task, and the code of the other cells. A cell with a dash has an
     * empty text.
     */
    private record Row(
            String what, List<String> java, String command, String message, String python) {}

    private static List<Row> rows() throws Exception {
        List<Row> rows = new ArrayList<>();
        for (String line : Files.readAllLines(PAGE)) {
            String[] cells = line.split("\\|");
            if (cells.length == 6 && cells[2].contains("`") && !cells[1].contains("to do")) {
                rows.add(
                        new Row(
                                cells[1].strip(),
                                CODE.matcher(cells[2]).results().map(m -> m.group(1)).toList(),
                                code(cells[3]),
                                code(cells[4]),
                                code(cells[5])));
            }
        }
        return rows;
    }

    private static String code(String cell) {
        Matcher code = CODE.matcher(cell);
        return code.find() ? code.group(1) : "";
    }

    @Test
    void noOperationOfJavaIsMissing() throws Exception {
        Set<String> listed = new TreeSet<>();
        rows().forEach(row -> listed.addAll(row.java()));
        assertThat(listed).hasSizeGreaterThan(30);
        Set<String> missing = new TreeSet<>();
        Set<String> known = new TreeSet<>();
        for (Class<?> door : DOORS) {
            for (Method method : door.getMethods()) {
                String name = door.getSimpleName() + "." + method.getName();
                if (method.getDeclaringClass() == door
                        && !Modifier.isStatic(method.getModifiers())
                        && isOperation(door, method)) {
                    (listed.contains(name) || UNLISTED.containsKey(name) ? known : missing)
                            .add(name);
                }
            }
        }
        assertThat(missing).isEmpty();
        assertThat(known).containsAll(UNLISTED.keySet()).contains("Forces.add");
        assertThat(listed).doesNotContainAnyElementsOf(UNLISTED.keySet());
        for (String name : listed) {
            String[] parts = name.split("\\.");
            DOORS.stream()
                    .filter(door -> door.getSimpleName().equals(parts[0]))
                    .forEach(
                            door ->
                                    assertThat(
                                                    Arrays.stream(door.getMethods())
                                                            .map(Method::getName))
                                            .as(name)
                                            .contains(parts[1]));
        }
    }

    private static boolean isOperation(Class<?> door, Method method) {
        return OPERATION.matcher(method.getName()).matches()
                || WHOLE.contains(door) && method.getReturnType() == void.class;
    }

    @Test
    void eachCellWorks(@TempDir Path folder) throws Exception {
        Matcher file = FILE.matcher(Files.readString(PAGE));
        while (file.find()) {
            Files.writeString(folder.resolve(file.group(1)), file.group(2));
        }
        try (Server server =
                        Server.start(
                                folder,
                                "serve",
                                folder.resolve("bench.yaml").toString(),
                                "--port",
                                "0",
                                "--json",
                                "--saves",
                                folder.resolve("saved").toString(),
                                "--pictures",
                                folder.toString());
                AgentClient boss =
                        Agents.join(
                                Integer.parseInt(server.port()),
                                Join.as("boss").withRole("control"))) {
            server.events().await("fault", fault -> true);
            assertThat(boss.command("snapshot", Map.of("image", "start")).accepted()).isTrue();
            List<Row> rows = rows();
            for (Row row : rows) {
                if (!row.message().isEmpty() && !row.message().contains("shut-down")) {
                    begin(boss);
                    say(boss, row);
                }
            }
            tryPython(folder, server.port(), rows);
            for (Row row : rows) {
                if (!row.command().isEmpty() && !row.command().equals("shut-down")) {
                    begin(boss);
                    command(folder, row, server.port());
                }
            }
            assertThat(boss.command("shut-down", Map.of()).accepted()).isTrue();
            assertThat(server.exitCode()).isZero();
        }
    }

    /** Restores the world of the page, and lets it run. */
    private static void begin(AgentClient boss) {
        assertThat(boss.command("rewind", Map.of("image", "start")).accepted()).isTrue();
        assertThat(boss.command("run", Map.of()).accepted()).isTrue();
    }

    @SuppressWarnings("unchecked") // JSON objects have text keys
    private static void say(AgentClient boss, Row row) {
        Map<String, Object> fields =
                new LinkedHashMap<>(new JsonMapper().readValue(row.message(), Map.class));
        String type = (String) fields.remove("t");
        if (type.equals("fork")) {
            var changes = (List<Map<String, Object>>) fields.getOrDefault("changes", List.of());
            assertThat(boss.foresee((int) fields.get("frames"), changes).find("sign").isPresent())
                    .isEqualTo(changes.isEmpty());
            return;
        }
        if (REPORTS.contains(type)) {
            assertThat(boss.report(type, fields).content()).as(row.message()).isNotEmpty();
            return;
        }
        var result = boss.command(type, fields);
        assertThat(result.accepted()).as("%s: %s", row.message(), result).isTrue();
    }

    /** Runs the command of a row, whose words are those of a shell. */
    private static void command(Path folder, Row row, String port) throws Exception {
        List<String> words = new ArrayList<>(List.of("control"));
        String printed = new Shell(folder).run("printf '%s\\n' " + row.command());
        for (String word : printed.lines().toList()) {
            Path file = folder.resolve(word);
            words.add(Files.exists(file) ? file.toString() : word);
        }
        words.addAll(List.of("--port", port));
        Reve.Outcome outcome = Reve.run(words.toArray(String[]::new));
        assertThat(outcome.code()).as("%s: %s", row.command(), outcome.err()).isZero();
    }

    private static void tryPython(Path folder, String port, List<Row> rows) throws Exception {
        List<String> script =
                new ArrayList<>(
                        List.of(
                                "import reve",
                                "boss = reve.control('127.0.0.1', " + port + ", name='snake')",
                                "def begin():",
                                "    assert boss.rewind('start')",
                                "    assert boss.run()"));
        Stream<String> calls = rows.stream().map(Row::python);
        calls.filter(call -> !call.isEmpty() && !call.contains("shut_down"))
                .forEach(
                        call -> {
                            script.add("begin()");
                            script.add("done = " + call);
                            script.add("assert done, done");
                        });
        Path file = Files.write(folder.resolve("calls.py"), script);
        ProcessBuilder builder =
                new ProcessBuilder("python3", file.toString()).redirectErrorStream(true);
        builder.environment().put("PYTHONPATH", Project.ROOT.resolve("agents/python").toString());
        Process python = builder.start();
        String said = new String(python.getInputStream().readAllBytes());
        assertThat(python.waitFor(300, TimeUnit.SECONDS)).isTrue();
        assertThat(python.exitValue()).as(said).isZero();
    }
}
