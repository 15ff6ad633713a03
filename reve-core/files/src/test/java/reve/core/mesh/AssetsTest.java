// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.withPrecision;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.Colour;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Texture;

import java.awt.image.BufferedImage;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Optional;

import javax.imageio.ImageIO;

class AssetsTest {

    @TempDir Path folder = Path.of("");

    private Assets assets() {
        return new Assets(new WorldFolder(folder));
    }

    /**
     * A stranger may have made a recording or store, and may have chosen the folder that it names.
     */
    @Test
    void aFolderThatARecordingNamesIsReadOnlyIfItContainsAWorldFile() throws Exception {
        Files.writeString(folder.resolve("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.writeString(folder.resolve("notes.txt"), "reverie: none\n");
        var assets = new Assets(WorldFolder.named(folder));
        assertThatThrownBy(() -> assets.mesh("t.obj"))
                .isInstanceOf(AssetException.class)
                .hasMessageContaining(folder + ", which the recording or store names")
                .hasMessageContaining("contains no world file");
        Files.writeString(folder.resolve("pond.yaml"), "# A pond.\nname: pond\nreve: 1\n");
        assertThat(assets.mesh("t.obj").triangles().remaining()).isEqualTo(3);
    }

    private Mesh mesh(String name, byte[] content) throws IOException, AssetException {
        Files.write(folder.resolve(name), content);
        return assets().mesh(name);
    }

    private Mesh mesh(String name, String content) throws IOException, AssetException {
        Files.writeString(folder.resolve(name), content);
        return assets().mesh(name);
    }

    private static float[] floats(FloatBuffer buffer) {
        float[] values = new float[buffer.remaining()];
        buffer.get(values);
        return values;
    }

    private static int[] ints(IntBuffer buffer) {
        int[] values = new int[buffer.remaining()];
        buffer.get(values);
        return values;
    }

    static byte[] png(int width, int height, int... rgb) throws IOException {
        var image = new BufferedImage(width, height, BufferedImage.TYPE_INT_RGB);
        image.setRGB(0, 0, width, height, rgb, 0, width);
        return encode(image, "png");
    }

    private static byte[] encode(BufferedImage image, String format) throws IOException {
        var out = new ByteArrayOutputStream();
        assertThat(ImageIO.write(image, format, out)).isTrue();
        return out.toByteArray();
    }

    @Test
    void nodesPutTheirTrianglesInPlace() throws Exception {
        Mesh mesh =
                mesh(
                        "moved.glb",
                        Gltf.triangle()
                                .glb(
                                        Gltf.TRIANGLE_MESH
                                                + ", \"nodes\": [{\"children\": [1],"
                                                + " \"translation\": [10, 0, 0]}, {\"mesh\": 0,"
                                                + " \"rotation\": [0, 0, 0.70710678, 0.70710678],"
                                                + " \"scale\": [2, 3, 1]}], \"scenes\":"
                                                + " [{\"nodes\": [0]}]"));

        assertThat(floats(mesh.vertices()))
                .containsExactly(new float[] {10, 0, 0, 10, 2, 0, 7, 0, 0}, withPrecision(1e-6f));
        assertThat(ints(mesh.triangles())).containsExactly(0, 1, 2);
        assertThat(mesh.file()).contains("moved.glb");
    }

    @Test
    void matricesAreByColumns() throws Exception {
        Mesh mesh =
                mesh(
                        "m.glb",
                        Gltf.triangle()
                                .glb(
                                        Gltf.TRIANGLE_MESH
                                                + ", "
                                                + Gltf.scene(
                                                        "{\"mesh\": 0, \"matrix\": [0, 0, 1, 0, 2,"
                                                                + " 0, 0, 0, 0, 1, 0, 0, 5, 6, 7,"
                                                                + " 1]}")));
        assertThat(floats(mesh.vertices())).containsExactly(5, 6, 7, 5, 6, 8, 7, 6, 7);
    }

    @Test
    void mirroredTrianglesStillFaceOutward() throws Exception {
        var gltf = Gltf.triangle();
        gltf.reals("VEC3", 3, 0, 0, 1, 0, 0, 1, 0, 0, 1);
        Mesh mesh =
                mesh(
                        "m.glb",
                        gltf.glb(
                                "\"meshes\": [{\"primitives\": [{\"attributes\": "
                                        + "{\"POSITION\": 0, \"NORMAL\": 1}}]}], "
                                        + Gltf.scene("{\"mesh\": 0, \"scale\": [1, 1, -1]}")));
        assertThat(ints(mesh.triangles())).containsExactly(0, 2, 1);
        assertThat(mesh.normals().map(AssetsTest::floats).orElseThrow()).startsWith(0, 0, -1);
    }

    @Test
    void stripsAndFansBecomeTrianglesOfOneSide() throws Exception {
        var gltf = new Gltf();
        gltf.reals("VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0);
        String primitive = "{\"attributes\": {\"POSITION\": 0}, \"mode\": %d}";
        String scene = Gltf.scene("{\"mesh\": 0}");
        assertThat(
                        ints(
                                mesh(
                                                "strip.glb",
                                                gltf.glb(
                                                        "\"meshes\": [{\"primitives\": ["
                                                                + String.format(primitive, 5)
                                                                + "]}], "
                                                                + scene))
                                        .triangles()))
                .containsExactly(0, 1, 2, 1, 3, 2, 2, 3, 4);
        assertThat(
                        ints(
                                mesh(
                                                "fan.glb",
                                                gltf.glb(
                                                        "\"meshes\": [{\"primitives\": ["
                                                                + String.format(primitive, 6)
                                                                + "]}], "
                                                                + scene))
                                        .triangles()))
                .containsExactly(0, 1, 2, 0, 2, 3, 0, 3, 4);
    }

    @Test
    void materialsMakeParts() throws Exception {
        var gltf = Gltf.triangle();
        int image = gltf.view(png(2, 1, 0xff0000, 0x00ff00));
        gltf.reals("VEC2", 2, 0, 0, 1, 0, 0, 1);
        Mesh mesh =
                mesh(
                        "parts.glb",
                        gltf.glb(
                                "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0,"
                                        + " \"TEXCOORD_0\": 1}, \"material\": 0}, {\"attributes\":"
                                        + " {\"POSITION\": 0}, \"material\": 1}]}], \"materials\":"
                                        + " [{\"pbrMetallicRoughness\": {\"baseColorTexture\":"
                                        + " {\"index\": 0}, \"metallicFactor\": 0, \"roughnessFactor\":"
                                        + " 0.5}}, {\"pbrMetallicRoughness\": {\"baseColorFactor\": [1,"
                                        + " 0, 0.2158605, 1]}}], \"textures\": [{\"source\": 0}],"
                                        + " \"images\": [{\"bufferView\": "
                                        + image
                                        + ", \"mimeType\": \"image/png\"}], "
                                        + Gltf.scene("{\"mesh\": 0}")));

        assertThat(mesh.parts()).hasSize(2);
        Material first = mesh.parts().get(0).material();
        assertThat(first.roughness()).isEqualTo(0.5);
        assertThat(first.metallic()).isZero();
        assertThat(first.texture().orElseThrow().width()).isEqualTo(2);
        assertThat(mesh.parts().get(1))
                .isEqualTo(
                        new Mesh.Part(
                                1,
                                1,
                                new Material(Colour.parse("#ff0080"), 1, 1, Optional.empty())));
        assertThat(mesh.textureCoordinates().map(AssetsTest::floats).orElseThrow())
                .containsExactly(0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0);
    }

    @Test
    void numbersMayLieBesideTheFileOrWithinIt() throws Exception {
        var gltf = Gltf.triangle();
        String rest = Gltf.TRIANGLE_MESH + ", " + Gltf.scene("{\"mesh\": 0}");
        Files.createDirectory(folder.resolve("models"));
        Files.write(folder.resolve("models/my data.bin"), gltf.binary());
        Mesh beside = mesh("models/beside.gltf", gltf.json("my%20data.bin", rest));
        Mesh within = mesh("models/within.gltf", gltf.embedded(rest));
        assertThat(floats(beside.vertices())).isEqualTo(floats(within.vertices()));
    }

    @Test
    void objFacesBecomeTrianglesByMaterial() throws Exception {
        Files.writeString(
                folder.resolve("paint.mtl"),
                """
                newmtl red
                Kd 1 0 0
                newmtl shiny
                Pr 0.1
                Pm 1
                map_Kd tile.png
                """);
        Files.write(folder.resolve("tile.png"), png(1, 1, 0x123456));
        Mesh mesh =
                mesh(
                        "square.obj",
                        """
                        mtllib paint.mtl
                        v 0 0 0
                        v 1 0 0
                        v 1 1 0
                        v 0 1 0
                        vt 0 0
                        vt 1 0.25
                        usemtl red
                        f 1 2 3 4
                        usemtl shiny
                        f -4/1 -3/2 -1/1
                        """);
        assertThat(ints(mesh.triangles())).containsExactly(0, 1, 2, 0, 2, 3, 4, 5, 6);
        assertThat(mesh.parts()).extracting(Mesh.Part::triangleCount).containsExactly(2, 1);
        assertThat(mesh.parts().get(0).material().colour()).isEqualTo(Colour.parse("#ff0000"));
        assertThat(mesh.parts().get(1).material().metallic()).isEqualTo(1);
        assertThat(mesh.parts().get(1).material().texture()).isPresent();
        assertThat(mesh.textureCoordinates().map(AssetsTest::floats).orElseThrow())
                .endsWith(0, 1, 1, 0.75f, 0, 1);
    }

    @Test
    void aMaterialOfAnObjFileHoldsUpToTheNextOne() throws Exception {
        Files.writeString(
                folder.resolve("paint.mtl"), "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n");
        Mesh mesh =
                mesh(
                        "corner.obj",
                        """
                        mtllib paint.mtl
                        v 0 0 0
                        v 1 0 0
                        v 0 1 0
                        v 0 0 1
                        f 1 2 3
                        usemtl red
                        f 1 3 2
                        f 1 2 4
                        g side
                        f 1 4 3
                        usemtl green
                        f 2 3 4
                        f 2 4 3
                        usemtl unknown
                        f 1 2 3
                        """);
        assertThat(mesh.parts()).extracting(Mesh.Part::triangleCount).containsExactly(1, 3, 2, 1);
        assertThat(mesh.parts())
                .extracting(part -> part.material().colour().toString())
                .containsExactly("#ffffffff", "#ff0000ff", "#00ff00ff", "#ffffffff");
    }

    @Test
    void itemsOfOneFileShareOneMesh() throws Exception {
        Files.writeString(folder.resolve("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.write(folder.resolve("t.png"), png(1, 1, 0));
        Assets assets = assets();
        assertThat(assets.mesh("t.obj")).isSameAs(assets.mesh("t.obj"));
        assertThat(assets.texture("t.png")).isSameAs(assets.texture("t.png"));
        assertThat(assets.texture("t.png").file()).contains("t.png");
    }

    @Test
    void pixelsComeAsTheFileHasThemGreyOnesToo() throws Exception {
        var grey = new BufferedImage(2, 1, BufferedImage.TYPE_BYTE_GRAY);
        grey.getRaster().setSample(0, 0, 0, 64);
        grey.getRaster().setSample(1, 0, 0, 200);
        Files.write(folder.resolve("grey.png"), encode(grey, "png"));
        Files.write(folder.resolve("rgb.png"), png(1, 2, 0x0a141e, 0xff8000));
        Files.write(
                folder.resolve("flat.jpg"),
                encode(ImageIO.read(folder.resolve("rgb.png").toFile()), "jpeg"));
        Assets assets = assets();
        assertThat(bytes(assets.texture("grey.png")))
                .containsExactly(64, 64, 64, 255, 200, 200, 200, 255);
        assertThat(bytes(assets.texture("rgb.png")))
                .containsExactly(10, 20, 30, 255, 255, 128, 0, 255);
        assertThat(assets.texture("flat.jpg").height()).isEqualTo(2);
    }

    private static int[] bytes(Texture texture) {
        var all = texture.rgba();
        int[] values = new int[all.remaining()];
        for (int i = 0; i < values.length; i++) {
            values[i] = all.get() & 0xff;
        }
        return values;
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "",
                "/etc/hostname",
                "../x.obj",
                "a/../../x.obj",
                "a//x.obj",
                "./x.obj",
                "C:\\x.obj",
                "a\\x.obj",
                "file:///etc/hostname",
                "http://example.org/x.obj",
                "x.obj\0",
                "a/",
                "out/x.obj",
                "out.obj",
                "data:,x"
            })
    void pathsThatLeadOutOfTheFolderAreRefused(String path) throws IOException {
        Path inside = Files.createDirectory(folder.resolve("world"));
        Files.createDirectory(inside.resolve("a"));
        Files.writeString(folder.resolve("x.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.createSymbolicLink(inside.resolve("out"), folder);
        Files.createSymbolicLink(inside.resolve("out.obj"), folder.resolve("x.obj"));
        var assets = new Assets(new WorldFolder(inside));
        assertThatThrownBy(() -> assets.mesh(path))
                .isInstanceOf(AssetException.class)
                .hasMessageMatching(
                        "(?s).*(within the world's folder|out of the world's folder"
                                + "|a path of 0 characters).*");
    }

    /** The content is a picture, so only the name can be the reason for the refusal. */
    @Test
    void aFileThatIsNotNamedAsAPictureIsNotOpened() throws Exception {
        for (String name : new String[] {"passwd", "key.pem", "picture.png.txt"}) {
            Files.write(folder.resolve(name), png(1, 1, 0));
            assertThatThrownBy(() -> assets().texture(name))
                    .isInstanceOf(AssetException.class)
                    .hasMessage(
                            name
                                    + ": expected a picture in a .png, .jpg or .jpeg file; "
                                    + "rename or convert it");
        }
        Files.write(folder.resolve("LOUD.PNG"), png(1, 1, 0));
        assertThat(assets().texture("LOUD.PNG").height()).isEqualTo(1);
    }

    @Test
    void linksWithinTheFolderAreFollowed() throws Exception {
        Files.writeString(folder.resolve("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.createSymbolicLink(folder.resolve("same.obj"), Path.of("t.obj"));
        assertThat(assets().mesh("same.obj").size(0)).isEqualTo(1);
    }
}
