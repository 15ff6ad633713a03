// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import de.javagl.jgltf.impl.v2.Buffer;
import de.javagl.jgltf.impl.v2.BufferView;
import de.javagl.jgltf.impl.v2.GlTF;
import de.javagl.jgltf.model.ElementType;
import de.javagl.jgltf.model.GltfConstants;

import org.jspecify.annotations.Nullable;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.HashMap;
import java.util.Map;

/**
 * Access to the numbers in the buffers of a glTF file, without copies of the buffers. The range of
 * an accessor is checked before any number is read.
 */
final class GltfAccessors {

    private final GlTF gltf;
    private final GltfContainer file;
    private final Sources sources;
    private final Map<Integer, ByteBuffer> buffers = new HashMap<>();

    GltfAccessors(GltfContainer file, Sources sources) {
        this.gltf = file.gltf();
        this.file = file;
        this.sources = sources;
    }

    /**
     * A glTF accessor, which consists of elements with several components. An element begins every
     * {@code stride} bytes of {@code bytes}. The field {@code type} is the GL code of a component's
     * type.
     */
    final class Accessor {
        private final String name;
        private final ByteBuffer bytes;
        private final int count;
        private final int stride;
        private final int type;
        private final int components;
        private final boolean normalized;

        private Accessor(
                String name,
                ByteBuffer bytes,
                int count,
                int stride,
                int type,
                int components,
                boolean normalized) {
            this.name = name;
            this.bytes = bytes;
            this.count = count;
            this.stride = stride;
            this.type = type;
            this.components = components;
            this.normalized = normalized;
        }

        /** Returns the number of elements. */
        int count() {
            return count;
        }

        /**
         * Checks that the accessor has {@code wanted} elements of {@code least} to {@code most}
         * components. The components must be floats, or unsigned integers that are normalized to 0
         * to 1.
         */
        void requireNumbers(String attribute, int least, int most, int wanted)
                throws AssetException {
            boolean real =
                    type == GltfConstants.GL_FLOAT
                            || normalized
                                    && (type == GltfConstants.GL_UNSIGNED_BYTE
                                            || type == GltfConstants.GL_UNSIGNED_SHORT);
            if (!real || components < least || components > most || count != wanted) {
                throw sources.refuse(
                        name
                                + " ("
                                + attribute
                                + ") has "
                                + count
                                + " x "
                                + components
                                + " numbers of type "
                                + type
                                + ", expected "
                                + wanted
                                + " x "
                                + least
                                + (least == most ? "" : " or " + most)
                                + " of type 5126 (or normalized 5121, 5123)");
            }
        }

        /**
         * Returns a component of an element as a float. The caller must first call {@link
         * #requireNumbers}.
         */
        float number(int element, int component) {
            int at = element * stride + component * sizeOf(type);
            return switch (type) {
                case GltfConstants.GL_UNSIGNED_BYTE -> (bytes.get(at) & 0xff) / 255f;
                case GltfConstants.GL_UNSIGNED_SHORT -> (bytes.getShort(at) & 0xffff) / 65535f;
                default -> bytes.getFloat(at);
            };
        }

        /**
         * Returns an element as a vertex number. Throws an exception unless it is below {@code
         * vertices}.
         */
        int index(int element, int vertices) throws AssetException {
            int at = element * stride;
            int index =
                    components != 1
                            ? -1
                            : switch (type) {
                                case GltfConstants.GL_UNSIGNED_BYTE -> bytes.get(at) & 0xff;
                                case GltfConstants.GL_UNSIGNED_SHORT -> bytes.getShort(at) & 0xffff;
                                case GltfConstants.GL_UNSIGNED_INT -> bytes.getInt(at);
                                default -> -1;
                            };
            if (index < 0 || index >= vertices) {
                throw sources.refuse(
                        name
                                + " (indices): element "
                                + element
                                + " is no number of a vertex, expected whole ones from 0 to "
                                + (vertices - 1));
            }
            return index;
        }
    }

    /**
     * Returns an accessor by its number.
     *
     * @param what the purpose of the accessor, for the message if it does not exist
     */
    Accessor find(@Nullable Integer number, String what) throws AssetException {
        var accessor =
                GltfContainer.element(gltf.getAccessors(), number, what + " accessor", sources);
        String name = "accessor " + number;
        if (accessor.getSparse() != null || accessor.getBufferView() == null) {
            throw sources.refuse(name + " is sparse, which is not supported; export it whole");
        }
        ElementType elements =
                accessor.getType() == null ? null : ElementType.forString(accessor.getType());
        int type = accessor.getComponentType() == null ? 0 : accessor.getComponentType();
        if (elements == null || sizeOf(type) == 0) {
            throw sources.refuse(name + " has no known type");
        }
        int components = elements.getNumComponents();
        int count = require(accessor.getCount(), name + " count", 1);
        int elementBytes = components * sizeOf(type);
        BufferView described =
                GltfContainer.element(
                        gltf.getBufferViews(), accessor.getBufferView(), "bufferView", sources);
        int stride =
                described.getByteStride() == null
                        ? elementBytes
                        : require(described.getByteStride(), name + " stride", elementBytes);
        ByteBuffer view = view(accessor.getBufferView());
        int offset =
                accessor.getByteOffset() == null
                        ? 0
                        : require(accessor.getByteOffset(), name + " byteOffset", 0);
        long end = offset + (count - 1L) * stride + elementBytes;
        if (end > view.remaining()) {
            throw sources.refuse(
                    name
                            + " needs "
                            + end
                            + " bytes of bufferView "
                            + accessor.getBufferView()
                            + ", which has "
                            + view.remaining());
        }
        ByteBuffer elementsOnly =
                view.slice(offset, (int) (end - offset)).order(ByteOrder.LITTLE_ENDIAN);
        return new Accessor(
                name,
                elementsOnly,
                count,
                stride,
                type,
                components,
                Boolean.TRUE.equals(accessor.isNormalized()));
    }

    /** Returns the bytes of a bufferView (a range of a glTF buffer), from position 0. */
    ByteBuffer view(@Nullable Integer number) throws AssetException {
        BufferView view =
                GltfContainer.element(gltf.getBufferViews(), number, "bufferView", sources);
        String name = "bufferView " + number;
        ByteBuffer buffer = buffer(view.getBuffer());
        int offset =
                view.getByteOffset() == null
                        ? 0
                        : require(view.getByteOffset(), name + " byteOffset", 0);
        int length = require(view.getByteLength(), name + " byteLength", 1);
        if ((long) offset + length > buffer.remaining()) {
            throw sources.refuse(
                    name
                            + " ends at byte "
                            + ((long) offset + length)
                            + " of a buffer that has "
                            + buffer.remaining());
        }
        return buffer.slice(offset, length);
    }

    private ByteBuffer buffer(@Nullable Integer number) throws AssetException {
        Buffer buffer = GltfContainer.element(gltf.getBuffers(), number, "buffer", sources);
        ByteBuffer bytes = buffers.get(number);
        if (bytes == null) {
            bytes =
                    buffer.getUri() != null
                            ? sources.read(buffer.getUri())
                            : file.binary()
                                    .orElseThrow(
                                            () ->
                                                    sources.refuse(
                                                            "buffer " + number + " has no data"));
            buffers.put(number, bytes);
        }
        return bytes;
    }

    private int require(@Nullable Integer value, String what, int least) throws AssetException {
        if (value == null || value < least) {
            throw sources.refuse(
                    what
                            + " is "
                            + (value == null ? "missing or unreadable" : value)
                            + ", expected at least "
                            + least);
        }
        return value;
    }

    private static int sizeOf(int type) {
        return switch (type) {
            case GltfConstants.GL_BYTE, GltfConstants.GL_UNSIGNED_BYTE -> 1;
            case GltfConstants.GL_SHORT, GltfConstants.GL_UNSIGNED_SHORT -> 2;
            case GltfConstants.GL_UNSIGNED_INT, GltfConstants.GL_FLOAT -> 4;
            default -> 0;
        };
    }
}
