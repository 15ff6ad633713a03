// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.derive.BoundingBoxes;
import reve.core.rule.Rules;
import reve.core.world.Item;
import reve.core.world.OffHeapArena;
import reve.core.world.World;

import java.io.IOException;
import java.net.URI;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

import javax.tools.DiagnosticCollector;
import javax.tools.JavaFileObject;
import javax.tools.SimpleJavaFileObject;
import javax.tools.ToolProvider;

/** The examples of {@code docs/semantics.md} and {@code docs/actions.md} are correct. */
class SemanticsDocumentTest {
    private static List<String> blocks(String page, String language) throws IOException {
        Matcher block =
                Pattern.compile("```" + language + "\n(.*?)```", Pattern.DOTALL)
                        .matcher(Files.readString(WorldFileTest.root().resolve("docs/" + page)));
        var blocks = new ArrayList<String>();
        while (block.find()) {
            blocks.add(block.group(1));
        }
        return blocks;
    }

    private static WorldDescription world(String page) throws Exception {
        return WorldFile.parse(
                page, blocks(page, "yaml").getFirst().getBytes(StandardCharsets.UTF_8));
    }

    @Test
    void rulesOfTheExampleGiveTheirSymbols() throws Exception {
        WorldDescription description = world("semantics.md");
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            new BoundingBoxes().update(world);
            new Rules(world, description.rules(), description.ruleSteps()).update(0);

            Item soup = world.find("soup").orElseThrow();
            assertThat(soup.semantic().get("hot")).contains(true);
            assertThat(soup.semantic().get("boils")).contains(true);
            assertThat(soup.semantic().get("advice")).contains("do not touch");
            assertThat(soup.semantic().get("on")).contains(List.of("table"));
            assertThat(world.find("table").orElseThrow().semantic().get("hot")).isEmpty();
        }
    }

    /** Returns the symbols of the items of an example, after its rules were evaluated. */
    private static Map<String, Map<String, Object>> symbols(String example) throws Exception {
        String text =
                blocks("semantics.md", "yaml").stream()
                        .filter(block -> block.contains("name: " + example + "\n"))
                        .findFirst()
                        .orElseThrow();
        WorldDescription description =
                WorldFile.parse(example, text.getBytes(StandardCharsets.UTF_8));
        assertThat(description.warnings()).isEmpty();
        Map<String, Map<String, Object>> symbols = new TreeMap<>();
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            new BoundingBoxes().update(world);
            new Rules(world, description.rules(), description.ruleSteps()).update(0);
            assertThat(world.events()).isEmpty();
            world.items().forEach(item -> symbols.put(item.name(), item.semantic().symbols()));
            return symbols;
        }
    }

    @Test
    void itemsOfTheExampleInherit() throws Exception {
        Map<String, Map<String, Object>> symbols = symbols("cupboard");
        assertThat(symbols.get("mug"))
                .containsEntry("classes", List.of("cup", "vessel", "container", "body"))
                .containsEntry("fragile", true)
                .containsEntry("holds", "liquid")
                .containsEntry("full", true)
                .containsEntry("forTea", true);
        assertThat(symbols.get("barrel"))
                .containsEntry("fragile", false)
                .containsEntry("full", false)
                .containsEntry("forTea", false);
        assertThat(symbols.get("hamper"))
                .containsEntry("classes", List.of("basket", "container", "body"))
                .containsEntry("forTea", false)
                .doesNotContainKeys("full", "holds");
    }

    @Test
    void symbolsOfTheExampleFollowFromPhysics() throws Exception {
        Map<String, Map<String, Object>> symbols = symbols("harbour");
        assertThat(symbols.get("crate"))
                .containsEntry("movable", true)
                .containsEntry("floats", true)
                .containsEntry("fragile", false)
                .containsEntry("weight", 9.81 * 600 * 0.125);
        assertThat(symbols.get("bottle"))
                .containsEntry("movable", true)
                .containsEntry("floats", false)
                .containsEntry("fragile", true);
        assertThat(symbols.get("quay"))
                .containsEntry("movable", false)
                .doesNotContainKeys("floats", "weight");
        assertThat(symbols.get("quay post"))
                .containsEntry("movable", false)
                .containsEntry("floats", false);
        assertThat(symbols.get("handle")).containsEntry("weak", true);
        assertThat(symbols.get("child")).containsEntry("strength", 40.0);
    }

    @Test
    void actionsOfTheExampleAreRead() throws Exception {
        WorldDescription description = world("actions.md");

        assertThat(description.agents().template().orElseThrow().capabilities())
                .containsExactly("grip");
        assertThat(description.items().getFirst().actions())
                .extracting(action -> action.name())
                .containsExactly("heat", "spill", "give");
    }

    @Test
    void actionInJavaCompilesAsItStands(@TempDir Path out) throws IOException {
        String source = blocks("actions.md", "java").getFirst();
        var file =
                new SimpleJavaFileObject(
                        URI.create("string:///example/Levitate.java"), JavaFileObject.Kind.SOURCE) {
                    @Override
                    public CharSequence getCharContent(boolean ignoreEncodingErrors) {
                        return source;
                    }
                };
        var problems = new DiagnosticCollector<JavaFileObject>();
        boolean compiled =
                ToolProvider.getSystemJavaCompiler()
                        .getTask(
                                null,
                                null,
                                problems,
                                List.of(
                                        "-d",
                                        out.toString(),
                                        "-Xlint:all,-path",
                                        "-Werror",
                                        "-proc:none",
                                        "-cp",
                                        System.getProperty("java.class.path")),
                                null,
                                List.of(file))
                        .call();

        assertThat(compiled).as("%s", problems.getDiagnostics()).isTrue();
    }
}
