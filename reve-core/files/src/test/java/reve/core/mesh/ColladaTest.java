// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Random;

/** COLLADA files: their geometries, scenes, units and axes, and files that are wrong. */
class ColladaTest {
    /** A box from 0 0 0 to 1 2 3, with normals and texture coordinates. */
    private static final String SOURCES =
            """
            <source id="at"><float_array id="at-array" count="24">0 0 0  1 0 0  0 2 0  1 2 0
              0 0 3  1 0 3  0 2 3  1 2 3</float_array><technique_common>
              <accessor source="#at-array" count="8" stride="3"/></technique_common></source>
            <source id="out"><float_array id="out-array" count="18">-1 0 0 1 0 0 0 -1 0 0 1 0 0 0 -1
              0 0 1</float_array><technique_common>
              <accessor source="#out-array" count="6" stride="3"/></technique_common></source>
            <source id="uv"><float_array id="uv-array" count="9">9 0 0  1 0  1 1  0 1</float_array>
              <technique_common><accessor source="#uv-array" count="4" stride="2" offset="1"/>
              </technique_common></source>
            <vertices id="corners"><input semantic="POSITION" source="#at"/></vertices>
            """;

    private static final String INPUTS =
            """
            <input semantic="VERTEX" source="#corners" offset="0"/>
            <input semantic="NORMAL" source="#out" offset="1"/>
            <input semantic="TEXCOORD" source="#uv" offset="2" set="0"/>
            """;

    /** The sides of the box as quadrilaterals: corner, normal and texture coordinates. */
    private static final String QUADS =
            "0 0 0 4 0 1 6 0 2 2 0 3  1 1 0 3 1 1 7 1 2 5 1 3  0 2 0 1 2 1 5 2 2 4 2 3 "
                    + "2 3 0 6 3 1 7 3 2 3 3 3  0 4 0 2 4 1 3 4 2 1 4 3  4 5 0 5 5 1 7 5 2 6 5 3";

    private static final String BOX =
            "<polylist count=\"6\" material=\"paint\">"
                    + INPUTS
                    + "<vcount>4 4 4 4 4 4</vcount><p>"
                    + QUADS
                    + "</p></polylist>";

    private static final String SCENE = "<node><instance_geometry url=\"#box\"/></node>";

    @TempDir Path folder = Path.of("");

    private static String file(String asset, String primitives, String nodes) {
        return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
                + "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\""
                + " version=\"1.4.1\"><asset>"
                + asset
                + "</asset><library_geometries><geometry id=\"box\"><mesh>"
                + SOURCES
                + primitives
                + "</mesh></geometry></library_geometries><library_visual_scenes>"
                + "<visual_scene id=\"scene\">"
                + nodes
                + "</visual_scene></library_visual_scenes>"
                + "<scene><instance_visual_scene url=\"#scene\"/></scene></COLLADA>";
    }

    private Mesh read(String text) throws IOException, AssetException {
        Files.writeString(folder.resolve("a.dae"), text);
        return new Assets(new WorldFolder(folder)).mesh("a.dae");
    }

    private static void assertExtent(Mesh mesh, double... lowAndHigh) {
        for (int axis = 0; axis < 3; axis++) {
            assertThat(mesh.min(axis)).as("low %d", axis).isCloseTo(lowAndHigh[axis], within(1e-5));
            assertThat(mesh.max(axis))
                    .as("high %d", axis)
                    .isCloseTo(lowAndHigh[3 + axis], within(1e-5));
        }
    }

    /** Each normal of a vertex points along the side of its triangles. */
    private static void assertNormalsPointOutwards(Mesh mesh) {
        for (int i = 0; i < mesh.triangles().remaining(); i += 3) {
            double[][] corners = new double[3][3];
            double[] normal = new double[3];
            for (int k = 0; k < 3; k++) {
                int at = 3 * mesh.triangles().get(i + k);
                for (int axis = 0; axis < 3; axis++) {
                    corners[k][axis] = mesh.vertices().get(at + axis);
                    normal[axis] += mesh.normals().orElseThrow().get(at + axis);
                }
            }
            double along = 0;
            for (int axis = 0; axis < 3; axis++) {
                int u = (axis + 1) % 3;
                int v = (axis + 2) % 3;
                double cross =
                        (corners[1][u] - corners[0][u]) * (corners[2][v] - corners[0][v])
                                - (corners[1][v] - corners[0][v]) * (corners[2][u] - corners[0][u]);
                along += cross * normal[axis];
            }
            assertThat(along).isPositive();
        }
    }

    @Test
    void aBoxHasItsVolumeItsNormalsAndItsTextureCoordinates() throws Exception {
        Mesh mesh = read(file("", BOX, SCENE));
        assertExtent(mesh, 0, 0, 0, 1, 2, 3);
        assertThat(MassProperties.of(mesh, 1).volume()).isCloseTo(6, within(1e-5));
        assertThat(mesh.triangles().remaining()).isEqualTo(36);
        assertThat(mesh.vertices().remaining()).as("shared corners").isEqualTo(3 * 24);
        assertNormalsPointOutwards(mesh);
        assertThat(mesh.textureCoordinates().orElseThrow().get(0)).isZero();
        assertThat(mesh.textureCoordinates().orElseThrow().get(1))
                .as("from below to from above")
                .isEqualTo(1);
        assertThat(mesh.file()).contains("a.dae");
    }

    /** The box is 1 x 2 x 3 units of 1 cm. */
    @ParameterizedTest
    @CsvSource({
        "X_UP, -0.02, 0, 0, 0, 0.01, 0.03",
        "Y_UP, 0, 0, 0, 0.01, 0.02, 0.03",
        "Z_UP, 0, 0, -0.02, 0.01, 0.03, 0"
    })
    void unitsBecomeMetresAndTheUpwardAxisBecomesY(
            String up, double x, double y, double z, double toX, double toY, double toZ)
            throws Exception {
        String asset = "<unit name=\"cm\" meter=\"0.01\"/><up_axis>" + up + "</up_axis>";
        Mesh mesh = read(file(asset, BOX, SCENE));
        assertExtent(mesh, x, y, z, toX, toY, toZ);
        assertThat(MassProperties.of(mesh, 1).volume()).isCloseTo(6e-6, within(1e-11));
        assertNormalsPointOutwards(mesh);
        Mesh own = new Assets(new WorldFolder(folder)).meshInAxesOfFile("a.dae");
        assertExtent(own, 0, 0, 0, 0.01, 0.02, 0.03);
    }

    /**
     * The scale acts first, then the rotation by 90° about Z, then the translation: the box from 0
     * 0 0 to 2 2 3 turns to -2 0 0 to 0 2 3, and moves.
     */
    @Test
    void transformationsActInTheirOrder() throws Exception {
        String nodes =
                "<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>"
                        + "<node><matrix>1 0 0 0  0 1 0 0  0 0 1 5  0 0 0 1</matrix>"
                        + "<instance_geometry url=\"#box\"/></node></node>";
        Mesh mesh = read(file("", BOX, nodes));
        assertExtent(mesh, 8, 0, 5, 10, 2, 8);
        assertThat(MassProperties.of(mesh, 1).volume()).isCloseTo(12, within(1e-4));
        assertNormalsPointOutwards(mesh);
    }

    @Test
    void aMirroredNodeStillFacesOutwards() throws Exception {
        Mesh mesh =
                read(
                        file(
                                "",
                                BOX,
                                "<node><scale>-1 1 1</scale><instance_geometry"
                                        + " url=\"#box\"/></node>"));
        assertExtent(mesh, -1, 0, 0, 0, 2, 3);
        assertThat(MassProperties.of(mesh, 1).volume()).isCloseTo(6, within(1e-5));
        assertNormalsPointOutwards(mesh);
    }

    @Test
    void aNodeMayOccurSeveralTimes() throws Exception {
        String nodes =
                "<node id=\"one\"><translate>0 0 9</translate><instance_geometry url=\"#box\"/>"
                        + "</node><node><translate>5 0 0</translate><instance_node"
                        + " url=\"#one\"/></node>";
        Mesh mesh = read(file("", BOX, nodes));
        assertExtent(mesh, 0, 0, 9, 6, 2, 12);
        assertThat(MassProperties.of(mesh, 1).volume()).isCloseTo(12, within(1e-4));
    }

    /** The same tetrahedron in all forms that a file may have. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    <triangles count="4">IN<p>0 2 1 0 1 4 1 2 4 2 0 4</p></triangles>
                    <polylist count="4">IN<vcount>3 3 3 3</vcount><p>0 2 1 0 1 4 1 2 4 2 0 4</p></polylist>
                    <polygons count="4">IN<p>0 2 1</p><p>0 1 4</p><p>1 2 4</p><p>2 0 4</p></polygons>
                    <tristrips count="1">IN<p>0 2 1 4 0 2</p></tristrips>
                    <trifans count="2">IN<p>4 0 1 2 0</p><p>0 2 1</p></trifans>
                    <triangles count="4">IN<p>0 2 1 0 1 4 1 2 4 2 0 4</p></triangles><lines count="1">IN<p>0 1</p></lines>
                    """)
    void polygonsStripsAndFansAreTriangles(String primitive) throws Exception {
        String input = "<input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>";
        Mesh mesh = read(file("", primitive.replace("IN", input), SCENE));
        assertThat(MassProperties.of(mesh, 1).volume()).isCloseTo(1, within(1e-6));
        assertThat(mesh.triangles().remaining()).isEqualTo(12);
        assertThat(mesh.normals()).isEmpty();
        assertThat(mesh.parts()).isEmpty();
    }

    @Test
    void materialsHaveTheirDiffuseColour() throws Exception {
        String nodes =
                "<node><instance_geometry url=\"#box\"><bind_material><technique_common>"
                        + "<instance_material symbol=\"paint\" target=\"#red\"/>"
                        + "</technique_common></bind_material></instance_geometry></node>";
        String text =
                file("", BOX, nodes)
                        .replace(
                                "<library_geometries>",
                                "<library_materials><material id=\"red\"><instance_effect"
                                        + " url=\"#shine\"/></material></library_materials>"
                                        + "<library_effects><effect id=\"shine\"><profile_COMMON>"
                                        + "<technique sid=\"common\"><phong><emission><color>0 0 0"
                                        + " 1</color></emission><diffuse><color sid=\"diffuse\">1 0.2 0"
                                        + " 1</color></diffuse></phong></technique></profile_COMMON>"
                                        + "</effect></library_effects><library_geometries>");
        Mesh mesh = read(text);
        assertThat(mesh.parts()).hasSize(1);
        assertThat(mesh.parts().getFirst().material().colour()).hasToString("#ff3300ff");
    }

    @Test
    void aWorldNamesAFileAndWeighsItsMesh() throws Exception {
        Files.writeString(
                folder.resolve("a.dae"),
                file(
                        "<up_axis>Z_UP</up_axis>",
                        BOX,
                        "<node><translate>-0.5 -1 -1.5</translate><instance_geometry"
                                + " url=\"#box\"/></node>"));
        Path world =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: w
                        items: [{name: box, physical: {shape: mesh, file: a.dae}, physics: {density: 10}}]
                        """);
        ItemDefinition box = WorldFile.load(world).items().getFirst();
        assertThat(box.physics("mass").orElseThrow()[0]).isCloseTo(60, within(1e-4));
        assertThat(box.shape().size(1)).isCloseTo(3, within(1e-6));
        Files.writeString(folder.resolve("a.dae"), "<COLLADA><up_axis>");
        assertThatThrownBy(() -> WorldFile.load(world))
                .isInstanceOf(WorldFileException.class)
                .hasMessageContaining("file: a.dae: not COLLADA: line 1: this is not XML: ");
    }

    /** Each change of a valid file is refused with this message. */
    @ParameterizedTest(name = "{0} -> {1}")
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    <COLLADA | <KOLLADA | this is not XML
                    0 0 0  1 0 0 | 0 zero 0 1 0 0 | line 2: <float_array>: `zero` is no number
                    1 2 3</float_array> | 1 2</float_array> | <accessor>: 8 vectors with a stride of 3 from number 0 do not fit 23 numbers and 3 components
                    count="8" stride="3" | count="8" stride="2" | <accessor>: 8 vectors with a stride of 2
                    count="8" stride="3" | count="9" stride="3" | <accessor>: 9 vectors
                    count="8" stride="3" | count="-8" stride="3" | count: found `-8`, expected a whole number
                    source="#at-array" | source="#none" | source: found `#none`, expected # and the id
                    source="#at-array" | source="http://x/y#at" | source: found `http://x/y#at`, expected # and the id
                    <p>0 0 0 4 | <p>8 0 0 4 | <p>: found the index 8, expected less than 8
                    <p>0 0 0 4 | <p>-1 0 0 4 | <p>: found -1.0, expected the number of a vertex
                    <p>0 0 0 4 | <p>0 0 0 4.5 | <p>: found 4.5, expected the number of a vertex
                    <p>0 0 0 4 | <p>0 0 4 | <p>: found 71 numbers, expected a multiple of 3
                    4 4</vcount> | 4 5</vcount> | the numbers of <vcount> have another sum than the 24 corners of <p>
                    4 4</vcount> | 4</vcount> | the numbers of <vcount> have another sum
                    semantic="VERTEX" | semantic="OTHER" | found no positions, expected an input VERTEX
                    offset="2" | offset="64" | the offset is 64, expected less than 64
                    url="#box" | url="#at" | <source>: found no <mesh>; export the geometry as triangles
                    <node> | <node><skew>1</skew> | <skew>: this transformation is not supported; bake it
                    <node> | <node><scale>1 2</scale> | <scale>: found 2 numbers, expected 3
                    <node> | <node><rotate>0 0 0 9</rotate> | <rotate>: the axis has no direction
                    <node> | <node><translate>0 0 NaN</translate> | <translate>: found NaN, expected a finite number
                    <node> | <node><instance_controller url="#box"/> | a skin or morph is not supported
                    <asset> | <asset><unit meter="0"/> | <unit>: meter: found `0`, expected a number of metres above 0
                    <asset> | <asset><!ELEMENT a> | line 2: a document type or an entity, expected neither
                    <asset> | <asset><up_axis>W_UP</up_axis> | <up_axis>: found `W_UP`, expected X_UP, Y_UP or Z_UP
                    <instance_geometry url="#box"/> | <instance_camera url="#box"/> | there are no triangles in it
                    0 0 0  1 0 0 | 1e39 0 0  1 0 0 | expected a finite number
                    """)
    void wrongFilesAreRefusedWithTheReason(String from, String to, String reason) {
        String text = file("", BOX, SCENE);
        assertThat(text).contains(from.strip());
        assertThatThrownBy(() -> read(text.replace(from.strip(), to.strip())))
                .isInstanceOf(AssetException.class)
                .hasMessageStartingWith("a.dae: ")
                .hasMessageContaining(reason.strip());
    }

    /** Entities would let a file read other files, or grow to any size. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    <!DOCTYPE COLLADA [<!ENTITY far SYSTEM "secret.txt">]> | &far;
                    <!DOCTYPE COLLADA [<!ENTITY a "1 1"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;">]> | &b;
                    <!DOCTYPE COLLADA SYSTEM "secret.txt"> | 0
                    '' | &far;
                    """)
    void documentTypesAndEntitiesAreRefused(String declaration, String use) throws IOException {
        Files.writeString(folder.resolve("secret.txt"), "<!ENTITY far \"7\">");
        String text =
                file("", BOX, SCENE)
                        .replace("?>\n", "?>\n" + declaration + "\n")
                        .replace("count=\"24\">0 0 0", "count=\"24\">" + use + " 0 0");
        assertThatThrownBy(() -> read(text))
                .isInstanceOf(AssetException.class)
                .hasMessageStartingWith("a.dae: not COLLADA: line ")
                .message()
                .doesNotContain("secret");
    }

    @Test
    void markupThatAParserWouldKeepAsAWholeIsRefused() throws Exception {
        String text = "x".repeat(70_000);
        for (String markup :
                new String[] {
                    "<!-- " + text + " > -->",
                    "<a id='>" + text + "'/>",
                    "<![CDATA[" + text + "]]>",
                    "<?a " + text + "?>"
                }) {
            assertThatThrownBy(() -> read(file(markup, BOX, SCENE)))
                    .hasMessage(
                            "a.dae: not COLLADA: line 2: a tag or comment is longer than 65536"
                                    + " bytes; shorten it");
        }
        Mesh mesh = read(file("<!-- <a> ' --><a id='>'/><![CDATA[ <b> ]]><?a '?>", BOX, SCENE));
        assertExtent(mesh, 0, 0, 0, 1, 2, 3);
        assertThatThrownBy(
                        () -> {
                            Files.write(
                                    folder.resolve("a.dae"),
                                    file("", BOX, SCENE).getBytes(StandardCharsets.UTF_16LE));
                            new Assets(new WorldFolder(folder)).mesh("a.dae");
                        })
                .hasMessageContaining("expected a text in UTF-8");
    }

    /** Each node contains the one before twice, so the last one contains 2^40 geometries. */
    @Test
    void nodesThatMultiplyAreRefused() {
        var nodes = new StringBuilder("<node id=\"n0\"><instance_geometry url=\"#box\"/></node>");
        for (int i = 1; i <= 40; i++) {
            nodes.append(
                    "<node id=\"n%d\"><instance_node url=\"#n%d\"/><instance_node url=\"#n%d\"/></node>"
                            .formatted(i, i - 1, i - 1));
        }
        String empty = "<lines count=\"1\">" + INPUTS + "<p>0 0 0 1 0 0</p></lines>";
        assertThatThrownBy(() -> read(file("", empty, nodes.toString())))
                .hasMessageContaining("the scene has more than 1048576 elements");
        assertThatThrownBy(() -> read(file("", BOX, nodes.toString())))
                .hasMessageContaining("more than 1048576 vertices; simplify the mesh");
        assertThatThrownBy(
                        () ->
                                read(
                                        file(
                                                "",
                                                BOX,
                                                "<node id=\"n\"><instance_node"
                                                        + " url=\"#n\"/></node>")))
                .hasMessageContaining("or a node contains itself");
        assertThatThrownBy(() -> read("<a>".repeat(300) + "</a>".repeat(300)))
                .hasMessageContaining("more than 96 levels");
        assertThatThrownBy(() -> read("<a>" + "<b/>".repeat(200_001) + "</a>"))
                .hasMessageContaining("200000 elements");
    }

    /** The time of reading would be the product of two long lists. */
    @Test
    void listsThatAreReadForEachElementOfAnotherListAreRefused() {
        String twice = BOX.replace("</polylist>", "<p/></polylist>");
        assertThatThrownBy(() -> read(file("", twice, SCENE)))
                .hasMessageContaining("<p>: found a second <p> in a <polylist>, expected one");
        String many = "<input semantic=\"COLOR\" source=\"#out\" offset=\"1\"/>".repeat(62);
        assertThatThrownBy(() -> read(file("", BOX.replace("<vcount>", many + "<vcount>"), SCENE)))
                .hasMessageContaining("found 65 inputs, expected at most 64");
        String none = BOX.replace("<vcount>4", "<vcount>" + "0 ".repeat(1_048_577) + "4");
        assertThatThrownBy(() -> read(file("", none, SCENE.repeat(5))))
                .hasMessageContaining("4194304 triangles");
    }

    @Test
    void aLongListOfNumbersIsReadInPieces() throws Exception {
        var corners = new StringBuilder();
        var faces = new StringBuilder();
        int count = 60_000;
        for (int i = 0; i < count; i++) {
            corners.append(i % 1000).append(' ').append(0.125 * (i / 1000)).append("\n0 ");
            if (i >= 2) {
                faces.append(i - 2).append('\t').append(i - 1).append(' ').append(i).append(' ');
            }
        }
        String text =
                file(
                                "",
                                "<triangles><input semantic=\"VERTEX\" source=\"#corners\"/><p>"
                                        + faces
                                        + "</p></triangles>",
                                SCENE)
                        .replaceFirst(
                                "(?s)0 0 0  1 0 0.*?</float_array>", corners + "</float_array>")
                        .replace("count=\"8\"", "count=\"" + count + "\"");
        Mesh mesh = read(text);
        assertThat(mesh.triangles().remaining()).isEqualTo(3 * (count - 2));
        for (int i = 0; i < count; i += 997) {
            int vertex = mesh.triangles().get(i < 2 ? i : 3 * (i - 2) + 2);
            assertThat(mesh.vertices().get(3 * vertex)).isEqualTo(i % 1000);
            assertThat(mesh.vertices().get(3 * vertex + 1)).isEqualTo(0.125f * (i / 1000));
        }
    }

    @Test
    void damagedFilesAreReadOrRefused() throws Exception {
        var random = new Random(Seed.of("damaged COLLADA"));
        byte[] whole = file("<unit meter=\"1\"/>", BOX, SCENE).getBytes(StandardCharsets.UTF_8);
        int refused = 0;
        for (int i = 0; i < 2000; i++) {
            byte[] damaged = whole.clone();
            for (int changes = 1 + random.nextInt(3); changes > 0; changes--) {
                int at = random.nextInt(damaged.length);
                damaged[at] =
                        random.nextBoolean()
                                ? damaged[random.nextInt(damaged.length)]
                                : (byte) random.nextInt(256);
            }
            Files.write(folder.resolve("a.dae"), damaged);
            try {
                new Assets(new WorldFolder(folder)).mesh("a.dae");
            } catch (AssetException reason) {
                refused++;
                assertThat(reason.getMessage())
                        .startsWith("a.dae: ")
                        .hasSizeLessThan(500)
                        .doesNotContain("\n")
                        .doesNotContain("Exception");
            }
        }
        assertThat(refused).isBetween(500, 1990);
    }
}
