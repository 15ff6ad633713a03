// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import de.javagl.jgltf.impl.v2.GlTF;
import de.javagl.jgltf.model.io.JsonError;
import de.javagl.jgltf.model.io.v2.GltfReaderV2;

import org.jspecify.annotations.Nullable;

import tools.jackson.core.JacksonException;
import tools.jackson.core.JsonParser;
import tools.jackson.core.JsonToken;
import tools.jackson.databind.json.JsonMapper;

import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/**
 * The parts of a glTF file: the JSON, and the binary chunk of a .glb file. The numbers in the JSON
 * are not checked yet.
 *
 * @param binary the binary chunk; empty for a .gltf file
 */
record GltfContainer(GlTF gltf, Optional<ByteBuffer> binary) {

    private static final int MAGIC = 0x46546c67;
    private static final int JSON_CHUNK = 0x4e4f534a;
    private static final int BINARY_CHUNK = 0x004e4942;

    /**
     * Maximum number of values in the JSON. The limit exists because one megabyte of JSON can take
     * hundreds of megabytes as Java objects.
     */
    private static final int MAX_TOKENS = 500_000;

    /**
     * Maximum length of a text in the JSON [characters]. The JSON library does not read longer
     * texts.
     */
    private static final int MAX_TEXT = 19_999_999;

    /** Maximum nesting depth of lists and objects in the JSON. */
    private static final int MAX_NESTING = 100;

    static GltfContainer read(byte[] bytes, Sources sources) throws AssetException {
        ByteBuffer file = ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
        if (file.remaining() < 4 || file.getInt(0) != MAGIC) {
            return new GltfContainer(parse(bytes, sources), Optional.empty());
        }
        if (file.remaining() < 12 || file.getInt(4) != 2) {
            throw sources.refuse("expected glTF of version 2");
        }
        if (Integer.toUnsignedLong(file.getInt(8)) != bytes.length) {
            throw sources.refuse(
                    "says that it has "
                            + Integer.toUnsignedLong(file.getInt(8))
                            + " bytes, found "
                            + bytes.length
                            + "; was it cut off?");
        }
        file.position(12);
        byte[] json = new byte[0];
        Optional<ByteBuffer> binary = Optional.empty();
        while (file.remaining() >= 8) {
            int length = file.getInt();
            int type = file.getInt();
            if (length < 0 || length > file.remaining()) {
                throw sources.refuse(
                        "a chunk of "
                                + Integer.toUnsignedLong(length)
                                + " bytes where only "
                                + file.remaining()
                                + " follow");
            }
            ByteBuffer chunk = file.slice(file.position(), length);
            if (type == JSON_CHUNK && json.length == 0) {
                json = new byte[length];
                chunk.get(json);
            } else if (type == BINARY_CHUNK && binary.isEmpty()) {
                binary = Optional.of(chunk);
            }
            file.position(file.position() + length);
        }
        return new GltfContainer(parse(json, sources), binary);
    }

    /** Returns the element of a list at an index. Throws an exception if there is none. */
    static <T> T element(
            @Nullable List<T> list, @Nullable Integer number, String what, Sources sources)
            throws AssetException {
        T found =
                list == null || number == null || number < 0 || number >= list.size()
                        ? null
                        : list.get(number);
        if (found == null) {
            throw sources.refuse(
                    "refers to "
                            + what
                            + " "
                            + (number == null ? "without a number" : number)
                            + ", there are "
                            + (list == null ? 0 : list.size()));
        }
        return found;
    }

    private static GlTF parse(byte[] json, Sources sources) throws AssetException {
        checkSize(json, sources);
        try {
            var reader = new GltfReaderV2();
            List<JsonError> unfit = new ArrayList<>();
            reader.setJsonErrorConsumer(
                    error -> {
                        // The library reports a property that glTF does not define as an error
                        // without an exception. Such properties are allowed, so these errors are
                        // ignored.
                        if (error.getThrowable() != null && unfit.isEmpty()) {
                            unfit.add(error);
                        }
                    });
            GlTF gltf = reader.read(new ByteArrayInputStream(json));
            if (!unfit.isEmpty()) {
                throw sources.refuse("not glTF: " + describe(unfit.getFirst()));
            }
            String version = gltf.getAsset() == null ? null : gltf.getAsset().getVersion();
            if (version == null || !version.startsWith("2.")) {
                throw sources.refuse(
                        "expected glTF of version 2, found "
                                + (version == null ? "none" : "version " + version));
            }
            return gltf;
        } catch (IOException | RuntimeException broken) {
            // The library throws unchecked exceptions for some malformed files. They are converted
            // into a refusal of the file.
            throw sources.refuse("not glTF: " + Reason.of(broken, "it contradicts itself"));
        }
    }

    private static String describe(JsonError error) {
        return error.getJsonPathString().replaceAll("\\.+", ".").substring(1)
                + ": "
                + Reason.of(error.getMessage(), "found another type than glTF has there");
    }

    private static void checkSize(byte[] json, Sources sources) throws AssetException {
        try (JsonParser parser = JsonMapper.shared().createParser(json)) {
            int tokens = 0;
            int depth = 0;
            for (var token = parser.nextToken(); token != null; token = parser.nextToken()) {
                depth += token.isStructStart() ? 1 : token.isStructEnd() ? -1 : 0;
                if (depth > MAX_NESTING) {
                    throw sources.refuse(
                            "line "
                                    + parser.currentLocation().getLineNr()
                                    + ": JSON nested more than "
                                    + MAX_NESTING
                                    + " deep");
                }
                if (token == JsonToken.VALUE_STRING && parser.getStringLength() > MAX_TEXT) {
                    throw sources.refuse(
                            "a text of more than "
                                    + MAX_TEXT
                                    + " characters; put "
                                    + "data into a .bin file beside it, or export it as .glb");
                }
                if (++tokens > MAX_TOKENS) {
                    throw sources.refuse("more than " + MAX_TOKENS + " values of JSON");
                }
            }
        } catch (JacksonException broken) {
            // The message omits the position if the exception contains none. This is true for
            // violations of the parser's own limits.
            String place =
                    broken.getLocation() == null
                            ? ""
                            : "line " + broken.getLocation().getLineNr() + ": ";
            throw sources.refuse(
                    place
                            + "not JSON: "
                            + Reason.of(
                                    broken.getOriginalMessage(), "a text or number is too long"));
        }
    }
}
