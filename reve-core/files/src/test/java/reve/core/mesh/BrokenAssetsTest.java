// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.fail;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.Random;
import java.util.zip.CRC32;

/** Files that are broken, by accident or on purpose. */
@Tag("slow")
class BrokenAssetsTest {

    private static final int MUTANTS = Integer.getInteger("reve.mesh.mutants", 2000);

    @TempDir Path folder = Path.of("");

    private void read(String name, byte[] content) throws IOException, AssetException {
        Files.write(folder.resolve(name), content);
        var assets = new Assets(new WorldFolder(folder));
        if (name.endsWith("png") || name.endsWith("jpg")) {
            assets.texture(name);
        } else {
            assets.mesh(name);
        }
    }

    private void assertRefused(String name, byte[] content, String reason) {
        assertThatThrownBy(() -> read(name, content))
                .isInstanceOf(AssetException.class)
                .hasMessageStartingWith(name + ": ")
                .hasMessageContaining(reason)
                .message()
                .doesNotContain("\n");
    }

    /** Replacements of pieces of a valid file, and the expected messages. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '`',
            textBlock =
                    """
                    "count": 3 | "count": 4 | accessor 0 needs 48 bytes of bufferView 0, which has 36
                    "count": 3 | "count": 2147483647 | accessor 0 needs
                    "count": 3 | "count": 4294967299 | accessors.count:
                    "count": 3 | "count": 0 | accessors.count: count < 1
                    "byteLength": 36}] | "byteLength": 37}] | ends at byte 37 of a buffer that has 36
                    "byteOffset": 0 | "byteOffset": -4 | bufferViews.byteOffset: byteOffset < 0
                    "byteOffset": 0 | "byteOffset": 2147483647 | of a buffer that has 36
                    "bufferView": 0 | "bufferView": 1 | refers to bufferView 1, there are 1
                    "bufferView": 0 | "sparse": {"count": 1} | accessor 0 is sparse
                    "buffer": 0 | "buffer": 1 | refers to buffer 1, there are 1
                    "VEC3" | "VEC2" | accessor 0 (POSITION) has 3 x 2 numbers of type 5126
                    "VEC3" | "VEC5" | accessors.type:
                    5126 | 5125 | accessor 0 (POSITION) has 3 x 3 numbers of type 5125
                    "POSITION": 0 | "COLOR_0": 0 | refers to position accessor without a number, there are 1
                    "POSITION": 0} | "POSITION": 0}, "indices": 0 | accessor 0 (indices): element 0 is no number
                    "POSITION": 0} | "POSITION": 0}, "mode": 1 | there are no triangles in it
                    "POSITION": 0} | "POSITION": 0}, "mode": 7 | mode:
                    "POSITION": 0} | "POSITION": 0}, "material": 2 | refers to material 2, there are 0
                    "mesh": 0 | "mesh": 0, "children": [0] | node 0 has two parents, or is its own ancestor
                    "mesh": 0 | "mesh": 0, "skin": 0 | node 0 has a skin
                    "mesh": 0 | "mesh": 0, "scale": [1, 1] | nodes.scale: Number of scale elements is < 3
                    "mesh": 0 | "mesh": 0, "scale": [1e38, 1e38, 1e38], "translation": [3e38, 0, 0] | finite
                    "nodes": [0] | "nodes": [0, 0] | node 0 has two parents
                    "2.0" | "1.0" | expected glTF of version 2, found version 1.0
                    "asset" | "extensionsRequired": ["KHR_draco_mesh_compression"], "asset" | KHR_draco_mesh_compression, which is not supported; export it without compression
                    "asset" | "extensionsRequired": ["EXT_meshopt_compression"], "asset" | EXT_meshopt_compression, which is not supported; export it without compression
                    {"byteLength": 36} | {"byteLength": 36, "uri": "../x.bin"} | without `..`
                    {"byteLength": 36} | {"byteLength": 36, "uri": "http://example.org/x.bin"} | expected a file beside it
                    {"byteLength": 36} | {"byteLength": 36, "uri": "data:;base64,###"} | broken base64
                    {"byteLength": 36} | {"byteLength": 36, "uri": "data:text/plain,x"} | not base64
                    {"asset" | {"asset": {, "asset" | not JSON
                    """)
    void refusalsNameWhatIsWrong(String right, String wrong, String reason) {
        var gltf = Gltf.triangle();
        String json = gltf.json("", Gltf.TRIANGLE_MESH + ", " + Gltf.scene("{\"mesh\": 0}"));
        assertThat(json).contains(right);
        byte[] file = Gltf.glb(json.replace(right, wrong), gltf.binary());
        try {
            assertRefused("x.glb", file, reason);
        } catch (AssertionError beside) { // A message about another file names that file.
            assertThatThrownBy(() -> read("x.glb", file))
                    .isInstanceOf(AssetException.class)
                    .hasMessageContaining(reason);
        }
    }

    @Test
    void filesThatAreCutOffAreRefused() {
        byte[] file = Gltf.triangle().glb(Gltf.TRIANGLE_MESH + ", " + Gltf.scene("{\"mesh\": 0}"));
        assertRefused("x.glb", Arrays.copyOf(file, file.length - 4), "was it cut off?");
        ByteBuffer.wrap(file).order(java.nio.ByteOrder.LITTLE_ENDIAN).putInt(12, 0x7fffffff);
        assertRefused("x.glb", file, "a chunk of 2147483647 bytes");
        assertRefused("x.gltf", "{}".getBytes(StandardCharsets.UTF_8), "version 2, found none");
        assertRefused("x.fbx", new byte[9], "convert others to .glb");
    }

    @Test
    void manyNodesCannotMultiplyAMeshBeyondItsLimit() {
        var gltf = new Gltf();
        gltf.reals("VEC3", 3, new float[3 * 3000]);
        String nodes = Gltf.list("{\"mesh\": 0}", 400);
        assertRefused(
                "x.glb",
                gltf.glb(Gltf.TRIANGLE_MESH + ", " + "\"nodes\": [" + nodes + "]"),
                "more than 1048576 vertices; simplify the mesh");
    }

    @Test
    void jsonOfTooManyValuesIsRefusedBeforeItBecomesObjects() {
        String json =
                "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": ["
                        + Gltf.list("{}", 300_000)
                        + "]}";
        assertRefused(
                "x.gltf", json.getBytes(StandardCharsets.UTF_8), "more than 500000 values of JSON");
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    v 0 0 0;f 1 2 3 | refers to vertex 2, there are 1
                    v 0 0 0;v 1 0 0;v 0 1 0 | no triangles
                    v 0 0 0;v 1 0 0;v 0 1e39 0;f 1 2 3 | expected a finite number
                    v 0 0 0;v 1 0 0;v 0 1 0;f 1/1 2/1 3/1 | refers to vt 1, there are 0
                    v 0 0;f 1 1 1 | not OBJ
                    v x y z | not OBJ
                    mtllib none.mtl;v 0 0 0;f 1 1 1 | no such file
                    """)
    void brokenObjIsRefused(String lines, String reason) {
        byte[] text = lines.replace(';', '\n').getBytes(StandardCharsets.UTF_8);
        assertThatThrownBy(() -> read("x.obj", text))
                .isInstanceOf(AssetException.class)
                .hasMessageContaining(reason);
    }

    @Test
    void hugeImagesAreRefusedByTheirHeader() throws IOException {
        byte[] image = AssetsTest.png(1, 1, 0);
        ByteBuffer header = ByteBuffer.wrap(image);
        header.putInt(16, 30_000).putInt(20, 30_000);
        var crc = new CRC32();
        crc.update(image, 12, 17);
        header.putInt(29, (int) crc.getValue());
        assertRefused("x.png", image, "an image of 30000 x 30000 pixels");
        assertRefused(
                "x.png",
                "GIF89a and more".getBytes(StandardCharsets.US_ASCII),
                "expected a PNG or JPEG image");
    }

    /** Random damage reaches the binary data, the JSON and the image of a model. */
    @Test
    void mutantsAreReadOrRefusedInOneLine() throws IOException {
        long seed = Seed.of("broken assets");
        var random = new Random(seed);
        byte[][] models = {model(), obj()};
        int refused = 0;
        for (int i = 0; i < MUTANTS; i++) {
            int which = i % 4 == 0 ? 1 : 0;
            byte[] mutant = mutate(models[which], models, random);
            try {
                read(which == 0 ? "m.glb" : "m.obj", mutant);
            } catch (AssetException expected) {
                refused++;
                assertThat(expected.getMessage())
                        .isNotBlank()
                        .doesNotContain("\n")
                        .hasSizeLessThan(1000);
            } catch (RuntimeException | Error other) {
                Path kept =
                        Files.write(
                                Files.createTempFile("mutant", which == 0 ? ".glb" : ".obj"),
                                mutant);
                fail("seed " + seed + ", mutant " + i + ", kept in " + kept, other);
            }
        }
        assertThat(refused).isBetween(MUTANTS / 4, MUTANTS - 1);
    }

    private static byte[] model() throws IOException {
        var gltf = Gltf.triangle();
        int image = gltf.view(AssetsTest.png(2, 2, 1, 2, 3, 4));
        gltf.reals("VEC2", 2, 0, 0, 1, 0, 0, 1);
        gltf.indices(0, 1, 2, 2, 1, 0);
        return gltf.glb(
                "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, "
                        + "\"TEXCOORD_0\": 1, \"NORMAL\": 0}, \"indices\": 2, \"material\": 0}]}], "
                        + "\"materials\": [{\"pbrMetallicRoughness\": {\"baseColorTexture\": "
                        + "{\"index\": 0}, \"baseColorFactor\": [1, 0.5, 0.2, 1]}}], \"textures\": "
                        + "[{\"source\": 0}], \"images\": [{\"bufferView\": "
                        + image
                        + "}], \"nodes\": [{\"children\": [1, 2], \"translation\": [1, 2, 3]}, "
                        + "{\"mesh\": 0, \"rotation\": [0, 0, 1, 0]}, {\"mesh\": 0, "
                        + "\"scale\": [1, 2, -1]}], \"scene\": 0, \"scenes\": [{\"nodes\": [0]}]");
    }

    private static byte[] obj() {
        return """
        # a square
        o thing
        v 0 0 0
        v 1 0 0
        v 1 1 0
        v 0 1 0
        vt 0 0
        vn 0 0 1
        g front
        usemtl stone
        f 1/1/1 2/1/1 3/1/1 4/1/1
        s off
        f -4//1 -2//1 -1//1
        """
                .getBytes(StandardCharsets.UTF_8);
    }

    /**
     * Flips bits, swaps digits, truncates, doubles or mixes. Most of these changes leave the file
     * almost valid.
     */
    private static byte[] mutate(byte[] model, byte[][] others, Random random) {
        byte[] mutant = model.clone();
        for (int changes = 1 + random.nextInt(4); changes > 0; changes--) {
            int at = random.nextInt(mutant.length);
            int length = Math.min(1 + random.nextInt(16), mutant.length - at);
            switch (random.nextInt(6)) {
                case 0 -> mutant[at] ^= (byte) (1 << random.nextInt(8));
                case 1 -> mutant[at] = (byte) random.nextInt();
                case 2 -> changeDigit(mutant, at, random);
                case 3 ->
                        Arrays.fill(
                                mutant, at, at + length, (byte) (random.nextBoolean() ? 0 : -1));
                case 4 ->
                        System.arraycopy(
                                mutant,
                                random.nextInt(mutant.length - length + 1),
                                mutant,
                                at,
                                length);
                default -> mutant = random.nextInt(4) > 0 ? mutant : Arrays.copyOf(mutant, at + 1);
            }
        }
        return mutant;
    }

    /**
     * Changes a digit. JSON with another number is still JSON, so this damage passes the parser.
     */
    private static void changeDigit(byte[] bytes, int from, Random random) {
        for (int at = from; at < bytes.length; at++) {
            if (bytes[at] >= '0' && bytes[at] <= '9') {
                bytes[at] = (byte) ('0' + random.nextInt(10));
                return;
            }
        }
    }
}
