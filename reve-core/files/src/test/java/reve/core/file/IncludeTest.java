// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.world.ItemDefinition;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;

/** Worlds of several files. */
class IncludeTest {
    private static final String START = "reve: 1\nname: w\n";

    @TempDir private Path folder = Path.of("");

    private void write(String name, String text) throws IOException {
        Path file = folder.resolve(name);
        Files.createDirectories(file.getParent());
        Files.writeString(file, text);
    }

    private WorldDescription load() throws IOException, WorldFileException {
        return WorldFile.load(folder.resolve("world.yaml"));
    }

    private List<String> problems() {
        WorldFileException refused = catchThrowableOfType(WorldFileException.class, this::load);
        assertThat(refused).isNotNull();
        return refused.problems().stream()
                .map(problem -> problem.toString().replace(folder + "/", ""))
                .toList();
    }

    @Test
    void whatIsIncludedComesBeforeWhatIncludesIt() throws Exception {
        write(
                "world.yaml",
                START
                        + """
                        include: [parts/cart.yaml, parts/laws.yaml]
                        laws: [newton_motion]
                        constants: {gravity: [0, -9.81, 0]}
                        items:
                          - {name: cart, like: cart, physics: {heat: 300}}
                        """);
        write(
                "parts/cart.yaml",
                """
                doc: What carts are.
                include: [more/wheel.yaml]
                prefabs: {cart: {physics: {mass: 5 kg}}}
                """);
        write(
                "parts/more/wheel.yaml",
                """
                properties: [{name: heat, kind: body, unit: K}]
                items: [{name: wheel, physics: {mass: 1, heat: 280 K}}]
                """);
        write(
                "parts/laws.yaml",
                """
                include: [more/wheel.yaml]
                laws: [hooke_spring, gravity_field]
                constants: {softening: 1 cm}
                """);

        WorldDescription world = load();

        assertThat(world.laws())
                .extracting(LawReference::name)
                .containsExactly("hooke_spring", "gravity_field", "newton_motion");
        assertThat(world.laws().getFirst().place()).endsWith("parts/laws.yaml:2:8");
        assertThat(world.items()).extracting(ItemDefinition::name).containsExactly("wheel", "cart");
        assertThat(world.items().getLast().physics("heat").orElseThrow()).containsExactly(300);
        assertThat(world.constants())
                .containsEntry("softening", List.of(0.01))
                .containsEntry("gravity", List.of(0.0, -9.81, 0.0));
    }

    @Test
    void problemsNameTheFileThatTheyAreIn() throws IOException {
        write(
                "world.yaml",
                START
                        + """
                        include: [a.yaml, b.yaml]
                        constants: {softening: 1}
                        items: [{name: ball, like: round}]
                        laws: [drag]
                        """);
        write(
                "a.yaml",
                """
                laws: [drag]
                items: [{name: ball}]
                prefabs: {round: {physics: {mass: 1 m}}}
                frame: {rate: 50}
                """);
        write("b.yaml", "constants: {softening: 2}\nprefabs: {round: {}}\n");

        assertThat(problems())
                .containsExactly(
                        "a.yaml:3:35: mass: unit m does not fit kg",
                        "a.yaml:4:1: unknown key `frame`; known here: doc, include, properties,"
                                + " laws, constants, substances, prefabs, classes, symbols, rules, items",
                        "b.yaml:2:11: duplicate prefab `round`, first in a.yaml:3",
                        "world.yaml:4:13: duplicate constant `softening`, first in b.yaml:1",
                        "world.yaml:5:16: duplicate item name `ball`, first in a.yaml:2",
                        "world.yaml:6:8: duplicate law `drag`, first in a.yaml:1");
    }

    @Test
    void syntaxErrorsOfAnIncludedFileAreItsOwn() throws IOException {
        write("world.yaml", START + "include: [a.yaml]\n");
        write("a.yaml", "items: [\n");

        assertThat(problems())
                .singleElement()
                .asString()
                .isEqualTo("a.yaml:1:8: `[` is not closed, which was noticed on line 2");
    }

    @Test
    void circlesAreRefused() throws IOException {
        write("world.yaml", START + "include: [a.yaml]\n");
        write("a.yaml", "include: [b.yaml]\n");
        write("b.yaml", "include: [a.yaml, world.yaml]\n");

        assertThat(problems())
                .containsExactly(
                        "b.yaml:1:11: include[0]: a.yaml is being read already: files include each"
                                + " other in a circle",
                        "b.yaml:1:19: include[1]: world.yaml is being read already: files include"
                                + " each other in a circle");
    }

    @Test
    void onlyFilesInsideTheFolderAreRead() throws IOException {
        Path outside = Files.createTempFile("outside", ".yaml");
        String within =
                ": expected a path within the world's folder, such as models/duck.glb: not "
                        + "an absolute one, without `..`, `.`, `:` or `\\`";
        try {
            Files.createSymbolicLink(folder.resolve("link.yaml"), outside);
            Files.createDirectory(folder.resolve("parts"));
            write(
                    "world.yaml",
                    START
                            + "include: ["
                            + outside
                            + ", ../x.yaml, a/../b.yaml, https://example.org/a.yaml, link.yaml,"
                            + " none.yaml, parts, \"a\\0b\", '']\n");

            assertThat(problems())
                    .map(problem -> problem.replaceAll("^world.yaml:3:\\d+: ", ""))
                    .map(problem -> problem.replace(outside.toString(), "OUTSIDE"))
                    .containsExactly(
                            "include[0]: OUTSIDE" + within,
                            "include[1]: ../x.yaml" + within,
                            "include[2]: a/../b.yaml" + within,
                            "include[3]: https://example.org/a.yaml" + within,
                            "include[4]: link.yaml: a link that leads out of the world's folder",
                            "include[5]: none.yaml: there is no such file in the world's folder",
                            "include[6]: parts: not a regular file",
                            "include[7]: a b" + within,
                            "include[8]: a path of 0 characters, expected 1 to 1024");
        } finally {
            Files.delete(outside);
        }
    }

    @Test
    void whatAnIncludedFileNamesLiesBesideIt() throws Exception {
        Files.createDirectories(folder.resolve("parts/models"));
        write(
                "world.yaml",
                START
                        + """
                        include: [parts/signs.yaml]
                        items:
                          - {name: here, physical: {shape: mesh, file: parts/models/sign.obj}}
                          - {name: there, like: sign}
                        """);
        write(
                "parts/signs.yaml",
                """
                prefabs: {sign: {physical: {shape: mesh, file: models/sign.obj}}}
                items:
                  - {name: "post {i}", repeat: posts.csv, physical: {location: "{[x, 0, 0]}"}}
                """);
        write("parts/posts.csv", "x\n7\n");
        write("parts/models/sign.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");

        WorldDescription world = WorldFile.load(folder.resolve("world.yaml"));

        assertThat(world.items())
                .extracting(ItemDefinition::name)
                .containsExactly("post 0", "here", "there");
        assertThat(world.items().get(2).shape())
                .as("one file, read once")
                .isSameAs(world.items().get(1).shape());
        assertThat(world.items().getFirst().location()).containsExactly(7, 0, 0);
    }

    @Test
    void deepIncludesAreRefused() throws IOException {
        write("world.yaml", START + "include: [p0.yaml]\n");
        for (int i = 0; i < 20; i++) {
            write("p" + i + ".yaml", "include: [p" + (i + 1) + ".yaml]\n");
        }
        assertThat(problems())
                .containsExactly(
                        "p15.yaml:1:11: include[0]: more than 16 files of "
                                + "which each is included by the one before");
    }

    @Test
    void allFilesTogetherHaveOneLimitOfSize() throws IOException {
        write("world.yaml", START + "include: [a.yaml, b.yaml]\n");
        write("a.yaml", "# comment\n".repeat(900_000) + "doc: a\n");
        write("b.yaml", "# comment\n".repeat(900_000) + "doc: b\n");

        assertThat(problems())
                .containsExactly(
                        "b.yaml:1:1: larger than 16 MiB, the limit for a "
                                + "world file with all that it includes");
    }

    @Test
    void aWorldThatIsNoFileIncludesNone() {
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () -> WorldFileTest.parse(START + "include: [a.yaml]\n"));

        assertThat(refused)
                .hasMessage(
                        "world.yaml:3:11: include[0]: a.yaml: a world that is not "
                                + "read from a file has no folder to find it in");
    }

    /**
     * A link in the folder is refused, because messages would quote lines of its target. A file
     * that the user names may be a link.
     */
    @Test
    void theWorldFileOfAFolderIsInTheFolder(@TempDir Path other) throws Exception {
        Path outside = Files.writeString(other.resolve("w.yaml"), START);
        Path link = Files.createSymbolicLink(folder.resolve("world.yaml"), outside);
        assertThat(
                        catchThrowableOfType(
                                WorldFileException.class, () -> WorldFile.loadFolder(folder)))
                .hasMessageContaining("world.yaml: a link that leads out of the world's folder");
        assertThat(WorldFile.load(link).name()).isEqualTo("w");

        Files.delete(link);
        write("here.yaml", START);
        Files.createSymbolicLink(link, Path.of("here.yaml"));
        assertThat(WorldFile.loadFolder(folder).name()).isEqualTo("w");
    }
}
