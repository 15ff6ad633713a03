// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import com.sun.management.OperatingSystemMXBean;

import java.awt.image.BufferedImage;
import java.io.BufferedOutputStream;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.io.PrintStream;
import java.lang.management.ManagementFactory;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.function.IntFunction;
import java.util.zip.CRC32;
import java.util.zip.Deflater;
import java.util.zip.DeflaterOutputStream;

import javax.imageio.ImageIO;

/**
 * Assets that are as large, or as costly to read, as a file of 64 MiB can be. The program writes
 * and reads the named cases, and prints for each its name, the milliseconds of processor time of
 * the reading, and the result.
 */
final class HeavyAssets {

    private static final int MIB = 1 << 20;
    private static final String DAE = "<COLLADA>";
    private static final String OBJ_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    /** Writes the files of a case into a folder and returns the assets to read. */
    interface Writer {
        List<String> write(Path folder) throws IOException;
    }

    private static final Map<String, Writer> CASES = new LinkedHashMap<>();

    static {
        CASES.put("obj-comments", text("x.obj", OBJ_TRIANGLE, "# nothing to see\n", ""));
        CASES.put("obj-one-comment", text("x.obj", OBJ_TRIANGLE + "#", "nothing to see ", "\n"));
        CASES.put("obj-empty-lines", text("x.obj", OBJ_TRIANGLE, "\n", ""));
        CASES.put("obj-joined-lines", text("x.obj", OBJ_TRIANGLE + "# ", "\\\n", ""));
        CASES.put("obj-joined-faces", text("x.obj", OBJ_TRIANGLE, "f 1 \\\n2 \\\n3\n", ""));
        CASES.put("obj-vertices", text("x.obj", OBJ_TRIANGLE, "v 0.125 -7.25e3 1234.5678\n", ""));
        CASES.put("obj-faces", text("x.obj", OBJ_TRIANGLE, "f 1/1/1 2/2/2 3/3/3\n", ""));
        CASES.put("obj-one-face", text("x.obj", OBJ_TRIANGLE + "f", " 1 2 3", "\n"));
        CASES.put("obj-long-number", text("x.obj", "v 0.", "1234567890", " 0 0\n"));
        CASES.put(
                "obj-names-of-groups",
                text("x.obj", OBJ_TRIANGLE, "g a b c d e f g h\nf 1 2 3\n", ""));
        CASES.put("obj-materials", text("x.obj", OBJ_TRIANGLE, "usemtl a\nusemtl b\n", ""));
        CASES.put("obj-zeros", text("x.obj", OBJ_TRIANGLE, "\0\0\0\0", ""));
        CASES.put("obj-full", HeavyAssets::fullObj);
        CASES.put("obj-groups-times-faces", HeavyAssets::groupsTimesFaces);
        CASES.put("mtl-options", HeavyAssets::materialOptions);
        CASES.put("links-to-one-obj", HeavyAssets::links);
        CASES.put("copies-of-one-obj", HeavyAssets::copies);
        CASES.put("gltf-lists", text("x.gltf", "", "[", ""));
        CASES.put("gltf-objects", text("x.gltf", "", "{\"a\":", ""));
        CASES.put("gltf-text", text("x.gltf", "{\"asset\":\"", "0123456789", "\"}"));
        CASES.put("gltf-number", text("x.gltf", "{\"asset\":1", "0123456789", "}"));
        CASES.put("gltf-gaps", text("x.gltf", "{\"asset\":", "        ", "{}}"));
        CASES.put("gltf-values", text("x.gltf", "{\"nodes\":[{}", ",{}", "]}"));
        CASES.put(
                "gltf-unknown-keys",
                text("x.gltf", "{\"asset\":{\"version\":\"2.0\"}", ",\"a\":0", "}"));
        CASES.put("glb-zeros", text("x.glb", "glTF\2\0\0\0", "\0\0\0\4", ""));
        CASES.put("gltf-400-buffers", folder -> buffers(folder, 400));
        CASES.put("gltf-many-files", HeavyAssets::bufferFiles);
        CASES.put("gltf-2000-images", HeavyAssets::images);
        CASES.put("gltf-2000-views-of-an-image", HeavyAssets::viewsOfAnImage);
        CASES.put("gltf-points", HeavyAssets::points);
        CASES.put("dae-numbers", text("x.dae", DAE + "<float_array>", "0 ", ""));
        CASES.put("dae-indices", text("x.dae", DAE + "<p>", "1234567 ", ""));
        CASES.put("dae-long-numbers", text("x.dae", DAE + "<p>", "-1.23456789e-12 ", ""));
        CASES.put("dae-elements", text("x.dae", DAE, "<a/>", ""));
        CASES.put("dae-levels", text("x.dae", DAE, "<a>", ""));
        CASES.put("dae-text", text("x.dae", DAE + "<a>", "nothing to see ", "</a></COLLADA>"));
        CASES.put("dae-one-comment", text("x.dae", DAE + "<!--", "nothing > to < see ", "-->"));
        CASES.put("dae-comments", text("x.dae", DAE, "<!-- nothing to see -->", ""));
        CASES.put("dae-raw-text", text("x.dae", DAE + "<a><![CDATA[", "nothing ", "]]></a>"));
        CASES.put("dae-attribute", text("x.dae", DAE + "<a id=\"", "nothing ", "\"/>"));
        CASES.put("dae-attributes", HeavyAssets::attributes);
        CASES.put("dae-entities", text("x.dae", DAE + "<p>", "&lt;", "</p>"));
        CASES.put("txt-heights", text("x.txt", "", "0 0 0 0 0 0 0 0\n", ""));
        CASES.put("txt-one-row", text("x.txt", "", "1.5 ", ""));
        CASES.put("txt-gaps", text("x.txt", "0 0\n", "  \t ", ""));
        CASES.put("jpeg-scans", folder -> write(folder, "x.jpg", Jpegs.withScans(4096, 1500)));
        CASES.put("jpeg-60-scans", folder -> write(folder, "x.jpg", Jpegs.withScans(4096, 54)));
        CASES.put("jpeg-segments", folder -> write(folder, "x.jpg", commented(31 * MIB)));
        CASES.put("png-chunks", folder -> write(folder, "x.png", chunks(31 * MIB, "teXt", 0)));
        CASES.put("png-compressed-text", folder -> write(folder, "x.png", bomb()));
        CASES.put("png-of-16-bits", folder -> write(folder, "x.png", png(4096, 16, 6)));
        CASES.put("png-16-million-pixels", folder -> write(folder, "x.png", png(4096, 8, 2)));
        CASES.put("png-too-large-a-file", text("x.png", "\u0089PNG\r\n\u001a\n", "\0\0\0\0", ""));
    }

    /** As many attributes with different names as fit. */
    private static List<String> attributes(Path folder) throws IOException {
        try (var out = Files.newBufferedWriter(folder.resolve("x.dae"))) {
            out.write(DAE);
            for (int name = 0; name < 6_000_000; ) {
                out.write("<a");
                for (int i = 0; i < 190; i++) {
                    out.write(" a" + Integer.toString(name++, 36) + "=''");
                }
                out.write("/>");
            }
        }
        return List.of("x.dae");
    }

    private HeavyAssets() {}

    static Set<String> names() {
        return CASES.keySet();
    }

    /**
     * @param arguments a folder, and the names of cases
     */
    public static void main(String[] arguments) throws IOException {
        PrintStream out = new PrintStream(System.out, true, StandardCharsets.UTF_8);
        for (int i = 1; i < arguments.length; i++) {
            Path folder = Files.createDirectories(Path.of(arguments[0], arguments[i]));
            List<String> paths = CASES.get(arguments[i]).write(folder);
            var assets = new Assets(new WorldFolder(folder));
            long start = cpuNanoseconds();
            String result = "read";
            for (String path : paths) {
                try {
                    if (path.endsWith("g")) {
                        assets.texture(path);
                    } else if (path.endsWith(".txt")) {
                        assets.heights(path);
                    } else {
                        assets.mesh(path);
                    }
                } catch (AssetException refused) {
                    result = refused.getMessage();
                }
            }
            out.println(
                    arguments[i] + "\t" + (cpuNanoseconds() - start) / 1_000_000 + "\t" + result);
            try (var files = Files.list(folder)) {
                for (Path file : files.toList()) {
                    Files.delete(file);
                }
            }
        }
    }

    /**
     * Returns the processor time of all threads of this process. Other work on the machine does not
     * change it.
     */
    private static long cpuNanoseconds() {
        return ((OperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean())
                .getProcessCpuTime();
    }

    private static List<String> write(Path folder, String name, byte[] content) throws IOException {
        Files.write(folder.resolve(name), content);
        return List.of(name);
    }

    /** A file of 64 MiB, which has a beginning, a repeated text and an end. */
    private static Writer text(String name, String begin, String again, String end) {
        return folder -> {
            byte[] part =
                    again.repeat(65_536 / again.length()).getBytes(StandardCharsets.ISO_8859_1);
            try (OutputStream out =
                    new BufferedOutputStream(Files.newOutputStream(folder.resolve(name)))) {
                out.write(begin.getBytes(StandardCharsets.ISO_8859_1));
                for (long left = 64L * MIB - 4096; left > part.length; left -= part.length) {
                    out.write(part);
                }
                out.write(end.getBytes(StandardCharsets.ISO_8859_1));
            }
            return List.of(name);
        };
    }

    /** As many vertices and triangles as a mesh may have, with no two equal corners. */
    private static List<String> fullObj(Path folder) throws IOException {
        int count = 1 << 19;
        try (var out = Files.newBufferedWriter(folder.resolve("x.obj"))) {
            for (int i = 0; i < count; i++) {
                out.write("v " + i + " " + i % 1000 + ".125 0.5\nvn 0 " + i % 3 + " 1\n");
            }
            for (int i = 1; i + 2 <= count; i++) {
                out.write(
                        "f " + i + "//" + i + " " + (i + 1) + "//" + (i + 1) + " " + (i + 2) + "//"
                                + (i + 2) + "\n");
            }
        }
        return List.of("x.obj");
    }

    /** A file of 4 MB in which each face is in thousands of groups. */
    private static List<String> groupsTimesFaces(Path folder) throws IOException {
        var text = new StringBuilder(OBJ_TRIANGLE).append('g');
        for (int i = 0; i < 60_000; i++) {
            text.append(' ').append(Integer.toString(i, 36));
        }
        text.append('\n').append("f 1 2 3\n".repeat(450_000));
        return write(folder, "x.obj", text.toString().getBytes(StandardCharsets.US_ASCII));
    }

    private static List<String> materialOptions(Path folder) throws IOException {
        Files.writeString(
                folder.resolve("x.mtl"),
                "newmtl a\nmap_Kd " + "-cc on ".repeat(140_000) + "x.png\n");
        return write(
                folder,
                "x.obj",
                ("mtllib x.mtl\n" + OBJ_TRIANGLE).getBytes(StandardCharsets.US_ASCII));
    }

    private static List<String> links(Path folder) throws IOException {
        List<String> names = new ArrayList<>(CASES.get("obj-comments").write(folder));
        for (int i = 0; i < 200; i++) {
            names.add("link" + i + ".obj");
            Files.createSymbolicLink(folder.resolve(names.getLast()), Path.of(names.getFirst()));
        }
        return names;
    }

    private static List<String> copies(Path folder) throws IOException {
        List<String> names = new ArrayList<>(CASES.get("obj-comments").write(folder));
        for (int i = 0; i < 200; i++) {
            names.add("copy" + i + ".obj");
            Files.createLink(
                    folder.resolve(names.getLast()).normalize(), folder.resolve(names.getFirst()));
        }
        return names;
    }

    private static String gltf(String rest) {
        return "{\"asset\": {\"version\": \"2.0\"}, " + rest + "}";
    }

    /** One triangle in the first of many buffers, which are one file of 64 MiB. */
    private static List<String> buffers(Path folder, int count) throws IOException {
        sparse(folder.resolve("x.bin"));
        return write(
                folder,
                "x.gltf",
                gltf(trianglesOf(count, i -> "x.bin")).getBytes(StandardCharsets.US_ASCII));
    }

    private static List<String> bufferFiles(Path folder) throws IOException {
        for (int i = 0; i < 20; i++) {
            sparse(folder.resolve(i + ".bin"));
        }
        return write(
                folder,
                "x.gltf",
                gltf(trianglesOf(20, i -> i + ".bin")).getBytes(StandardCharsets.US_ASCII));
    }

    private static void sparse(Path file) throws IOException {
        try (var channel =
                FileChannel.open(file, StandardOpenOption.CREATE, StandardOpenOption.WRITE)) {
            channel.write(ByteBuffer.allocate(1), 64L * MIB - 1);
        }
    }

    /** A primitive for each buffer. */
    private static String trianglesOf(int count, IntFunction<String> file) {
        List<String> buffers = new ArrayList<>();
        List<String> views = new ArrayList<>();
        List<String> accessors = new ArrayList<>();
        List<String> primitives = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            buffers.add("{\"byteLength\": " + 64 * MIB + ", \"uri\": \"" + file.apply(i) + "\"}");
            views.add("{\"buffer\": " + i + ", \"byteLength\": " + 64 * MIB + "}");
            accessors.add(
                    "{\"bufferView\": "
                            + i
                            + ", \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"}");
            primitives.add("{\"attributes\": {\"POSITION\": " + i + "}}");
        }
        return "\"buffers\": "
                + buffers
                + ", \"bufferViews\": "
                + views
                + ", \"accessors\": "
                + accessors
                + ", \"meshes\": [{\"primitives\": "
                + primitives
                + "}], \"nodes\": [{\"mesh\": 0}]";
    }

    /** 2,000 materials, each with an image of its own. All images are the same file. */
    private static List<String> images(Path folder) throws IOException {
        var image = new ByteArrayOutputStream();
        ImageIO.write(new BufferedImage(1024, 1024, BufferedImage.TYPE_INT_RGB), "png", image);
        Files.write(folder.resolve("x.png"), image.toByteArray());
        var gltf = Gltf.triangle();
        return write(folder, "x.glb", gltf.glb(manyImages(2000, i -> "{\"uri\": \"x.png\"}")));
    }

    /**
     * 2,000 views of one file that begin at the same place. Each has the same image, which has one
     * pixel and is large.
     */
    private static List<String> viewsOfAnImage(Path folder) throws IOException {
        byte[] image = chunks(31 * MIB, "teXt", 0);
        var gltf = Gltf.triangle();
        gltf.view(image);
        String view = "{\"buffer\": 0, \"byteOffset\": 36, \"byteLength\": %d}";
        StringBuilder views = new StringBuilder();
        for (int i = 0; i < 2000; i++) {
            views.append(", ").append(view.formatted(image.length));
        }
        String json =
                gltf.json(
                        "",
                        manyImages(
                                2000,
                                i ->
                                        "{\"bufferView\": "
                                                + (i + 2)
                                                + ", \"mimeType\": \"image/png\"}"));
        int end = json.indexOf("], \"accessors\"");
        return write(
                folder,
                "x.glb",
                Gltf.glb(json.substring(0, end) + views + json.substring(end), gltf.binary()));
    }

    private static String manyImages(int count, IntFunction<String> image) {
        List<String> images = new ArrayList<>();
        List<String> textures = new ArrayList<>();
        List<String> materials = new ArrayList<>();
        List<String> primitives = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            images.add(image.apply(i));
            textures.add("{\"source\": " + i + "}");
            materials.add(
                    "{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": " + i + "}}}");
            primitives.add("{\"attributes\": {\"POSITION\": 0}, \"material\": " + i + "}");
        }
        return "\"images\": "
                + images
                + ", \"textures\": "
                + textures
                + ", \"materials\": "
                + materials
                + ", \"meshes\": [{\"primitives\": "
                + primitives
                + "}], \"nodes\": [{\"mesh\": 0}]";
    }

    /** Many nodes with many primitives that are no triangles. */
    private static List<String> points(Path folder) throws IOException {
        var gltf = Gltf.triangle();
        String mesh =
                "\"meshes\": [{\"primitives\": ["
                        + Gltf.list("{\"attributes\": {\"POSITION\": 0}, \"mode\": 0}", 20_000)
                        + "]}]";
        return write(
                folder,
                "x.glb",
                gltf.glb(mesh + ", \"nodes\": [" + Gltf.list("{\"mesh\": 0}", 50_000) + "]"));
    }

    /** A JPEG image that follows as many comments as fit into the file. */
    private static byte[] commented(int size) throws IOException {
        byte[] image = Jpegs.progressive(8);
        ByteBuffer file = ByteBuffer.allocate(size + image.length);
        file.put(image, 0, 2);
        while (file.position() < size - 8) {
            file.putShort((short) 0xfffe).putShort((short) 3).put((byte) 0);
        }
        file.put(image, 2, image.length - 2);
        return Arrays.copyOf(file.array(), file.position());
    }

    /** A PNG of one pixel with as many chunks of a kind as fit before its pixels. */
    private static byte[] chunks(int size, String kind, int length) throws IOException {
        byte[] image = AssetsTest.png(1, 1, 0);
        ByteBuffer file = ByteBuffer.allocate(size + image.length);
        file.put(image, 0, 33);
        byte[] chunk = chunk(kind, new byte[length]);
        while (file.position() < size - chunk.length) {
            file.put(chunk);
        }
        file.put(image, 33, image.length - 33);
        return Arrays.copyOf(file.array(), file.position());
    }

    private static byte[] chunk(String kind, byte[] content) {
        ByteBuffer chunk = ByteBuffer.allocate(12 + content.length);
        chunk.putInt(content.length).put(kind.getBytes(StandardCharsets.US_ASCII)).put(content);
        var crc = new CRC32();
        crc.update(chunk.array(), 4, 4 + content.length);
        return chunk.putInt((int) crc.getValue()).array();
    }

    /** A PNG of one pixel with texts of a gigabyte each, compressed. */
    private static byte[] bomb() throws IOException {
        var text = new ByteArrayOutputStream();
        text.writeBytes("a\0\0".getBytes(StandardCharsets.US_ASCII));
        try (var out = new DeflaterOutputStream(text, new Deflater(9))) {
            byte[] zeros = new byte[MIB];
            for (int i = 0; i < 1024; i++) {
                out.write(zeros);
            }
        }
        byte[] image = AssetsTest.png(1, 1, 0);
        var file = new ByteArrayOutputStream();
        file.write(image, 0, 33);
        byte[] packed = text.toByteArray();
        for (int i = 0; i < 10; i++) {
            file.writeBytes(chunk("zTXt", packed));
            file.writeBytes(chunk("iCCP", packed));
        }
        file.write(image, 33, image.length - 33);
        return file.toByteArray();
    }

    /** A PNG of black pixels. */
    private static byte[] png(int side, int bits, int colourType) throws IOException {
        int channels = colourType == 6 ? 4 : 3;
        var file = new ByteArrayOutputStream();
        file.writeBytes(new byte[] {(byte) 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'});
        file.writeBytes(
                chunk(
                        "IHDR",
                        ByteBuffer.allocate(13)
                                .putInt(side)
                                .putInt(side)
                                .put((byte) bits)
                                .put((byte) colourType)
                                .array()));
        var pixels = new ByteArrayOutputStream();
        try (var out = new DeflaterOutputStream(pixels)) {
            byte[] row = new byte[1 + side * channels * bits / 8];
            for (int y = 0; y < side; y++) {
                out.write(row);
            }
        }
        file.writeBytes(chunk("IDAT", pixels.toByteArray()));
        file.writeBytes(chunk("IEND", new byte[0]));
        return file.toByteArray();
    }
}
