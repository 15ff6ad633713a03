// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.concurrent.atomic.AtomicLong;
import java.util.zip.CRC32;

/**
 * Malicious files. They have extreme sizes, nesting, cycles or counts, refer to themselves, or end
 * early. Each file is read, or is refused in one line that names a file and a reason.
 */
class HostileAssetsTest {

    private static final String SCENE = Gltf.TRIANGLE_MESH + ", " + Gltf.scene("{\"mesh\": 0}");

    @TempDir private Path folder;

    /**
     * Returns the bytes of each case by its name. The first word of the name is the name of the
     * file.
     */
    private static Map<String, byte[]> corpus() throws IOException {
        Map<String, byte[]> corpus = new LinkedHashMap<>();
        addValues(corpus);
        addNothing(corpus);
        addNodes(corpus);
        addJson(corpus);
        addObj(corpus);
        addEnds(corpus);
        addImages(corpus);
        return corpus;
    }

    /** Replaces each number of a valid file by each impossible value. */
    private static void addValues(Map<String, byte[]> corpus) {
        String json = Gltf.triangle().json("", SCENE);
        for (String right :
                new String[] {
                    "\"count\": 3",
                    "\"byteOffset\": 0",
                    "\"byteLength\": 36}]",
                    "\"bufferView\": 0",
                    "\"componentType\": 5126",
                    "\"type\": \"VEC3\"",
                    "\"buffer\": 0",
                    "\"POSITION\": 0",
                    "\"mesh\": 0",
                    "\"nodes\": [0]"
                }) {
            assertThat(json).contains(right);
            String key = right.substring(0, right.indexOf(':'));
            String close = right.endsWith("}]") ? "}]" : "";
            for (String wrong :
                    new String[] {
                        "-1",
                        "0",
                        "7",
                        "2147483647",
                        "2147483648",
                        "-2147483648",
                        "1e300",
                        "0.5",
                        "\"0\"",
                        "null",
                        "true",
                        "[]",
                        "{}",
                        "[[[]]]"
                    }) {
                corpus.put(
                        "x.glb " + key + ": " + wrong,
                        Gltf.glb(
                                json.replace(right, key + ": " + wrong + close),
                                Gltf.triangle().binary()));
            }
        }
    }

    /** Removes the element of each list of a valid file. */
    private static void addNothing(Map<String, byte[]> corpus) throws IOException {
        Gltf gltf = Gltf.triangle();
        gltf.view(AssetsTest.png(1, 1, 0));
        String json =
                gltf.json(
                        "",
                        "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0},"
                                + " \"material\": 0}]}], \"materials\": [{\"pbrMetallicRoughness\":"
                                + " {\"baseColorFactor\": [1, 1, 1, 1], \"baseColorTexture\":"
                                + " {\"index\": 0}}}], \"textures\": [{\"source\": 0}], \"images\":"
                                + " [{\"bufferView\": 1}], \"nodes\": [{\"mesh\": 0, \"translation\":"
                                + " [0, 0, 0], \"children\": []}], \"scenes\": [{\"nodes\": [0]}]");
        for (String list :
                new String[] {
                    "meshes",
                    "primitives",
                    "materials",
                    "baseColorFactor",
                    "textures",
                    "images",
                    "nodes",
                    "translation",
                    "children",
                    "scenes",
                    "buffers",
                    "bufferViews",
                    "accessors"
                }) {
            int begin = json.indexOf("\"" + list + "\": [") + list.length() + 5;
            for (String nothing : new String[] {"null, ", "null], \"extras\": ["}) {
                corpus.put(
                        "x.glb " + list + ": " + nothing,
                        Gltf.glb(
                                json.substring(0, begin) + nothing + json.substring(begin),
                                gltf.binary()));
            }
        }
    }

    private static void addNodes(Map<String, byte[]> corpus) {
        Gltf gltf = Gltf.triangle();
        corpus.put(
                "x.glb a node that is its own child",
                gltf.glb(
                        Gltf.TRIANGLE_MESH
                                + ", "
                                + Gltf.scene("{\"mesh\": 0, \"children\": [0]}")));
        corpus.put(
                "x.glb two nodes that are each other's children",
                gltf.glb(
                        Gltf.TRIANGLE_MESH
                                + ", "
                                + Gltf.scene("{\"children\": [1]}", "{\"children\": [0]}")));
        corpus.put(
                "x.glb a circle of nodes without a scene",
                gltf.glb(
                        Gltf.TRIANGLE_MESH
                                + ", \"nodes\": [{\"children\": [1]}, {\"children\": [2]},"
                                + " {\"children\": [0]}]"));
        StringBuilder chain = new StringBuilder("{\"mesh\": 0}");
        for (int i = 1; i < 5000; i++) {
            chain.append(", {\"children\": [").append(i - 1).append("]}");
        }
        corpus.put(
                "x.glb nodes nested 5000 deep",
                gltf.glb(Gltf.TRIANGLE_MESH + ", \"nodes\": [" + chain + "]"));
        for (String matrix :
                new String[] {
                    "[]",
                    "[1]",
                    "[1e39]",
                    "[null]",
                    "\"\"",
                    "[" + Gltf.list("0", 16) + "]",
                    "[" + Gltf.list("3e38", 16) + "]",
                    "[" + Gltf.list("1", 100_000) + "]"
                }) {
            corpus.put(
                    "x.glb matrix "
                            + matrix.substring(0, Math.min(20, matrix.length()))
                            + " of "
                            + matrix.length(),
                    gltf.glb(
                            Gltf.TRIANGLE_MESH
                                    + ", "
                                    + Gltf.scene("{\"mesh\": 0, \"matrix\": " + matrix + "}")));
        }
        for (String uri :
                new String[] {
                    "x.gltf",
                    "x.gltf#",
                    "./x.gltf",
                    "../x.gltf",
                    "/etc/passwd",
                    "data:;base64,",
                    "data:;base64,AAAA",
                    "data:,",
                    "data:;base64",
                    "%00",
                    "%2e%2e/x.bin",
                    "file:///etc/passwd",
                    "x y.bin",
                    "",
                    " ",
                    "..",
                    "a/../../b.bin",
                    "\\\\host\\x.bin"
                }) {
            corpus.put("x.gltf buffer " + uri, bytes(gltf.json(uri.replace("\\", "\\\\"), SCENE)));
            corpus.put(
                    "x.gltf image " + uri,
                    bytes(
                            gltf.embedded(
                                    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\":"
                                            + " 0}, \"material\": 0}]}], \"materials\":"
                                            + " [{\"pbrMetallicRoughness\": {\"baseColorTexture\":"
                                            + " {\"index\": 0}}}], \"textures\": [{\"source\": 0}],"
                                            + " \"images\": [{\"uri\": \""
                                            + uri.replace("\\", "\\\\")
                                            + "\"}], "
                                            + Gltf.scene("{\"mesh\": 0}"))));
        }
    }

    private static void addJson(Map<String, byte[]> corpus) {
        for (int depth : new int[] {99, 101, 499, 501, 5000, 100_000}) {
            corpus.put(
                    "x.gltf lists " + depth + " deep",
                    bytes("[".repeat(depth) + "]".repeat(depth)));
            corpus.put(
                    "x.gltf objects " + depth + " deep",
                    bytes("{\"extras\":".repeat(depth) + "0" + "}".repeat(depth)));
            corpus.put(
                    "x.gltf extras " + depth + " deep",
                    bytes(
                            Gltf.triangle()
                                    .embedded(
                                            SCENE
                                                    + ", \"extras\": "
                                                    + "[".repeat(depth)
                                                    + "]".repeat(depth))));
        }
        for (String text :
                new String[] {
                    "",
                    " ",
                    "null",
                    "0",
                    "\"\"",
                    "[]",
                    "{}",
                    "[{}]",
                    "\0",
                    "{\"asset\":null}",
                    "{\"asset\":[]}",
                    "{\"asset\":{\"version\":2}}",
                    "\ufeff{}",
                    "{",
                    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":{}}",
                    "{\"asset\":{\"version\":\"\u0000\"}}",
                    "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[null],\"nodes\":[{\"mesh\":0}]}",
                    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[null]}",
                    "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[null],\"scene\":0}",
                    "{\"a\":" + "9".repeat(5000) + "}",
                    "{\"" + "k".repeat(100_000) + "\":1}"
                }) {
            corpus.put(
                    "x.gltf JSON " + text.substring(0, Math.min(70, text.length())), bytes(text));
        }
    }

    private static void addObj(Map<String, byte[]> corpus) {
        String points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (String line :
                new String[] {
                    "f 0 1 2",
                    "f 1 2 4",
                    "f -4 -3 -2",
                    "f 1 2 2147483647",
                    "f 1 2 2147483648",
                    "f 1 2 -2147483649",
                    "f 1 2 99999999999999999999",
                    "f 1/1/1/1 2 3",
                    "f 1/ 2/ 3/",
                    "f /1 2 3",
                    "f 1//1 2 3",
                    "f 1/1 2 3",
                    "f a b c",
                    "f 1.5 2 3",
                    "f 1 2",
                    "f",
                    "f 1",
                    "f - 2 3",
                    "f 1 2 3 \\",
                    "f 1 2 \\\n3",
                    "v",
                    "v 1",
                    "v 1 2",
                    "v nan 0 0",
                    "v 1e39 0 0\nf 1 2 4",
                    "v Infinity 0 0\nf 1 2 4",
                    "v 0x1p3 0 0",
                    "v 1,5 0 0",
                    "vt",
                    "vt x",
                    "vn 1",
                    "vn 1 2",
                    "usemtl",
                    "usemtl none\nf 1 2 3",
                    "mtllib",
                    "mtllib x.obj",
                    "mtllib none.mtl",
                    "mtllib ../x.mtl",
                    "mtllib /etc/passwd",
                    "g",
                    "o",
                    "s off",
                    "\0\0\0",
                    "v " + "1".repeat(100_000) + " 0 0",
                    "f " + "1 ".repeat(3000),
                    "\u00fc\u0416\n",
                    "call x.obj",
                    "sh rm -r",
                    "l 1 2",
                    "p 1",
                    "curv 0 1 1 2",
                    "\\",
                    "\\\\\\",
                    "#"
                }) {
            corpus.put(
                    "x.obj "
                            + line.substring(0, Math.min(20, line.length())).strip()
                            + " of "
                            + line.length(),
                    bytes(points + line + "\n"));
        }
    }

    private static void addEnds(Map<String, byte[]> corpus) throws IOException {
        byte[] glb = Gltf.triangle().glb(SCENE);
        byte[] png = AssetsTest.png(2, 2, 1, 2, 3, 4);
        byte[] jpeg = Jpegs.progressive(16);
        for (int twelfth = 0; twelfth < 12; twelfth++) {
            corpus.put("x.glb cut at " + twelfth + "/12", cut(glb, twelfth));
            corpus.put("x.png cut at " + twelfth + "/12", cut(png, twelfth));
            corpus.put("x.jpg cut at " + twelfth + "/12", cut(jpeg, twelfth));
        }
    }

    private static byte[] cut(byte[] whole, int twelfth) {
        return Arrays.copyOf(whole, whole.length * twelfth / 12);
    }

    private static void addImages(Map<String, byte[]> corpus) throws IOException {
        for (int side : new int[] {0, 1, -1, 8193, 1 << 16, Integer.MAX_VALUE}) {
            byte[] png = AssetsTest.png(1, 1, 0);
            ByteBuffer.wrap(png).putInt(16, side).putInt(20, side);
            var crc = new CRC32();
            crc.update(png, 12, 17);
            ByteBuffer.wrap(png).putInt(29, (int) crc.getValue());
            corpus.put("x.png of " + side + " a side", png);
            byte[] jpeg = Jpegs.progressive(16);
            int frame = find(jpeg, 0xc2);
            ByteBuffer.wrap(jpeg)
                    .putShort(frame + 5, (short) side)
                    .putShort(frame + 7, (short) side);
            corpus.put("x.jpg of " + side + " a side", jpeg);
        }
        corpus.put("x.jpg of 65 scans", Jpegs.withScans(16, 65));
        for (int marker : new int[] {0xc4, 0xda, 0xdb, 0xdd}) {
            byte[] jpeg = Jpegs.progressive(16);
            ByteBuffer.wrap(jpeg).putShort(find(jpeg, marker) + 2, (short) 0xffff);
            corpus.put("x.jpg with a long segment " + Integer.toHexString(marker), jpeg);
            byte[] none = Jpegs.progressive(16);
            ByteBuffer.wrap(none).putShort(find(none, marker) + 2, (short) 0);
            corpus.put("x.jpg with an empty segment " + Integer.toHexString(marker), none);
        }
    }

    private static int find(byte[] jpeg, int marker) {
        int at = 2;
        while (at < jpeg.length - 1
                && ((jpeg[at] & 0xff) != 0xff || (jpeg[at + 1] & 0xff) != marker)) {
            at++;
        }
        return Math.min(at, jpeg.length - 10);
    }

    private static byte[] bytes(String text) {
        return text.getBytes(StandardCharsets.UTF_8);
    }

    @Test
    void eachIsReadOrRefusedInALineThatNamesFileAndReason() throws Exception {
        Map<String, byte[]> corpus = corpus();
        assertThat(corpus).hasSizeGreaterThan(300);
        int refused = 0;
        for (Map.Entry<String, byte[]> file : corpus.entrySet()) {
            String name = file.getKey().substring(0, file.getKey().indexOf(' '));
            Files.write(folder.resolve(name), file.getValue());
            try {
                var assets = new Assets(new WorldFolder(folder));
                if (name.endsWith("g")) {
                    assets.texture(name);
                } else {
                    assets.mesh(name);
                }
            } catch (AssetException reason) {
                refused++;
                assertThat(reason.getMessage())
                        .as(file.getKey())
                        .hasSizeBetween(12, 400)
                        .doesNotContain("\n")
                        .doesNotContainPattern("(java|tools|com|de)\\.\\w|[a-z]Exception|: null$");
            } catch (RuntimeException | Error other) {
                throw new AssertionError(file.getKey(), other);
            }
        }
        assertThat(refused).isBetween(250, corpus.size() - 20);
    }

    @Test
    void aRequiredExtensionWithoutANameIsRefused() throws IOException {
        Files.write(
                folder.resolve("x.gltf"),
                bytes(Gltf.triangle().embedded(SCENE + ", \"extensionsRequired\": [null]")));
        assertThatThrownBy(() -> new Assets(new WorldFolder(folder)).mesh("x.gltf"))
                .isInstanceOf(AssetException.class)
                .hasMessage(
                        "x.gltf: not glTF: " + "extensionsRequired: found null, expected names");
    }

    @Test
    void aFileThatIsItsOwnLinkIsRefused() throws Exception {
        Files.createSymbolicLink(folder.resolve("x.obj"), Path.of("x.obj"));
        Files.createDirectory(folder.resolve("y.obj"));
        var assets = new Assets(new WorldFolder(folder));
        assertThatThrownBy(() -> assets.mesh("x.obj"))
                .isInstanceOf(AssetException.class)
                .message()
                .startsWith("x.obj: cannot be opened: ")
                .doesNotContain("Exception");
        assertThatThrownBy(() -> assets.mesh("y.obj")).hasMessage("y.obj: not a regular file");
    }

    @Test
    void linksToOneFileShareWhatWasReadAndWhyItIsRefused() throws Exception {
        Files.writeString(folder.resolve("x.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.writeString(folder.resolve("none.obj"), "# nothing\n");
        Files.createSymbolicLink(folder.resolve("link.obj"), Path.of("x.obj"));
        Files.createSymbolicLink(folder.resolve("nolink.obj"), Path.of("none.obj"));
        var assets = new Assets(new WorldFolder(folder));
        assertThat(assets.mesh("link.obj")).isSameAs(assets.mesh("x.obj"));
        assertThatThrownBy(() -> assets.mesh("none.obj"))
                .hasMessage("none.obj: there are no triangles in it");
        assertThatThrownBy(() -> assets.mesh("nolink.obj"))
                .hasMessage(
                        "nolink.obj: is the same file as none.obj: there are no triangles in it");
    }

    /** Vertices and triangles of other assets count, too. */
    @Test
    void whatAllMeshesOfAWorldTakeIsLimited() throws Exception {
        Files.writeString(folder.resolve("x.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        var triangles = new Budget(System::nanoTime);
        triangles.begin();
        triangles.takeTriangles("y.obj", Budget.MAX_TRIANGLES);
        assertThatThrownBy(() -> new Assets(new WorldFolder(folder), triangles).mesh("x.obj"))
                .hasMessage(
                        "x.obj: the meshes of this world have more than 4194304 triangles "
                                + "together");
        var bytes = new Budget(System::nanoTime);
        bytes.begin();
        bytes.takeBytes("y.obj", Budget.MAX_BYTES);
        assertThatThrownBy(() -> new Assets(new WorldFolder(folder), bytes).mesh("x.obj"))
                .hasMessage(
                        "x.obj: the meshes and images of this world have more than 268435456 "
                                + "bytes together");
    }

    @Test
    void readingThatTakesTooLongIsGivenUp() throws Exception {
        Files.writeString(folder.resolve("x.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.copy(folder.resolve("x.obj"), folder.resolve("y.obj"));
        var clock = new AtomicLong();
        var assets =
                new Assets(
                        new WorldFolder(folder), new Budget(() -> clock.addAndGet(5_000_000_000L)));
        assets.mesh("x.obj");
        assertThatThrownBy(() -> assets.mesh("y.obj"))
                .hasMessage(
                        "y.obj: the meshes and images of this world take longer than 60 s to read;"
                                + " use fewer or smaller ones");
    }
}
