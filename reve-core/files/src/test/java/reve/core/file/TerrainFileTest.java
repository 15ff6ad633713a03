// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.WorldPrototype;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.FloatBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;

import javax.imageio.ImageIO;

/** World files with terrains whose heights are in files. */
class TerrainFileTest {
    @TempDir Path folder = Path.of("");

    @BeforeEach
    void writeHeights() throws IOException {
        Files.createDirectory(folder.resolve("maps"));
        Files.writeString(folder.resolve("maps/dale0.txt"), "0 0.1 0\n1 2 3\n");
        Files.writeString(folder.resolve("maps/dale1.txt"), "0 0\n4 0\n");
        Files.writeString(folder.resolve("maps/bad.txt"), "0 0\n4\n");
        var image = new BufferedImage(3, 2, BufferedImage.TYPE_USHORT_GRAY);
        image.getRaster().setSample(2, 1, 0, 65535);
        ImageIO.write(image, "png", folder.resolve("hill.png").toFile());
    }

    private List<ItemDefinition> items(String text) throws IOException, WorldFileException {
        Path file = Files.writeString(folder.resolve("world.yaml"), "reve: 1\nname: w\n" + text);
        return WorldFile.load(file).items();
    }

    private static float[] vertices(ItemDefinition item) {
        FloatBuffer all = ((Mesh) item.shape()).vertices();
        float[] vertices = new float[all.remaining()];
        all.get(vertices);
        return vertices;
    }

    @Test
    void aFileAndAListOfTheSameHeightsGiveTheSameVertices() throws Exception {
        List<ItemDefinition> items =
                items(
                        """
                        items:
                          - {name: a, physical: {shape: terrain, size: [4, 2], file: maps/dale0.txt}}
                          - {name: b, physical: {shape: terrain, size: [4, 2], heights: [[0, 0.1, 0], [1, 2, 3]]}}
                        """);
        assertThat(vertices(items.getFirst())).containsExactly(vertices(items.getLast()));
        assertThat(((Mesh) items.getFirst().shape()).triangles())
                .isEqualTo(((Mesh) items.getLast().shape()).triangles());
    }

    /** A saved world names the file, and does not contain its heights. */
    @Test
    void anItemIsWrittenWithItsFileAndReadBack() throws Exception {
        ItemDefinition hill =
                items(
                                "items: [{name: hill, physical: {shape: terrain, size: 40 20 m, file:"
                                        + " hill.png, heightRange: -20 350 cm}}]")
                        .getFirst();
        String written = new ItemWriter(WorldPrototype.standard("si-f64")).write(hill);
        assertThat(written)
                .contains("shape: terrain")
                .contains("file: hill.png")
                .contains("heightRange: [-0.2, 3.5]")
                .doesNotContain("vertices");
        ItemDefinition again =
                WorldFile.parseItem(
                        "hill",
                        written,
                        WorldPrototype.standard("si-f64"),
                        new Assets(new WorldFolder(folder)));
        assertThat(vertices(again)).containsExactly(vertices(hill));
        assertThat(again.shape().size(1)).isEqualTo(hill.shape().size(1));
    }

    @Test
    void repeatedItemsAndPrefabsNameFiles() throws Exception {
        List<ItemDefinition> items =
                items(
                        """
                        prefabs:
                          tile: {physical: {shape: terrain, size: [2, 2]}}
                          listed: {physical: {shape: terrain, size: [2, 2], heights: [[0, 0], [0, 1]]}}
                          imaged: {physical: {shape: terrain, size: [2, 2], file: hill.png, heightRange: [0, 1]}}
                        items:
                          - {name: "tile {i}", like: tile, repeat: 2, physical: {file: "maps/dale{i}.txt"}}
                          - {name: hill, like: imaged}
                        """);
        assertThat(items).extracting(item -> item.shape().size(1)).containsExactly(3.0, 4.0, 1.0);
    }

    /** Each is refused at the value, in line 3. */
    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    »size: [4, 2], file: hill.png ! shape terrain needs `heightRange` for an image
                    size: [4, 2], file: hill.png, heightRange: »3 ! heightRange: found 1 number, expected 2 numbers in m
                    size: [4, 2], file: hill.png, heightRange: »3 1 m ! heightRange: found 3.0 and 1.0 m, expected the height of black and a greater one of white
                    size: [4, 2], file: hill.png, heightRange: »1 1 kg ! heightRange: unit kg does not fit m
                    size: [4, 2], file: hill.png, heightRange: »0 1e40 m ! heightRange: 1.0E40 is not within the range of a 32-bit real
                    size: [4, 2], file: maps/dale0.txt, »heightRange: [0, 1] ! `heightRange` does not go with shape terrain, which takes `size` and `file`
                    size: [4, 2], »heights: [[0, 0], [0, 0]], file: maps/dale0.txt ! `heights` does not go with shape terrain
                    »file: maps/dale0.txt ! shape terrain needs `size`
                    size: »[4, 2, 1], file: maps/dale0.txt ! size: found 3 numbers, expected 2 numbers in m
                    size: [4, 2], file: »maps/none.txt ! file: maps/none.txt: there is no such file in the world
                    size: [4, 2], file: »maps/bad.txt ! file: maps/bad.txt: no terrain: line 2: found 1 numbers, expected 2
                    size: [4, 2], file: »../hill.txt ! file: ../hill.txt: expected a path within the world
                    size: [4, 2], file: »models/duck.glb ! file: models/duck.glb: there is no such file
                    """)
    void wrongTerrainsAreRefusedWhereTheyAreWrong(String keys, String message) throws Exception {
        String line = "  - {name: t, physical: {shape: terrain, " + keys + "}}";
        int column = line.indexOf('»') + 1;
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () -> items("items:\n" + line.replace("»", "") + "\n"));
        assertThat(refused.problems())
                .singleElement()
                .satisfies(
                        problem -> {
                            assertThat(problem.line()).isEqualTo(4);
                            if (!message.startsWith("shape terrain needs")) {
                                assertThat(problem.column()).isEqualTo(column);
                            }
                            assertThat(problem.message()).startsWith(message);
                        });
    }

    @Test
    void aRangeBelongsToTerrainsOnly() {
        assertThatThrownBy(
                        () ->
                                items(
                                        "items: [{name: b, physical: {shape: box, size: [1, 1, 1],"
                                                + " heightRange: [0, 1]}}]"))
                .hasMessageContaining(
                        "`heightRange` does not go with shape box, which takes `size`");
    }

    /** The check of prefabs finds a wrong file before an item uses it. */
    @Test
    void aPrefabThatNoItemUsesIsChecked() {
        assertThatThrownBy(
                        () ->
                                items(
                                        "prefabs: {t: {physical: {shape: terrain, size: [2, 2], file:"
                                                + " maps/bad.txt}}}"))
                .hasMessageContaining("file: maps/bad.txt: no terrain: line 2");
    }

    /** Edits come from clients, which must not make the server read files. */
    @Test
    void editsNameNoFiles() throws WorldFileException {
        var reader = new EditReader(WorldPrototype.standard("si-f64"));
        assertThatThrownBy(
                        () ->
                                reader.add(
                                        "{items: [{name: t, physical: {shape: terrain, size: [2,"
                                                + " 2], file: maps/dale0.txt}}]}",
                                        new EditReader.Room()))
                .hasMessageContaining(
                        "maps/dale0.txt: a world that is not read from a file has no folder to"
                                + " find it in");
    }
}
