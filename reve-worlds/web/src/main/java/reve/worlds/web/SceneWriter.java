// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.jspecify.annotations.Nullable;

import reve.core.file.CameraDescription;
import reve.core.world.ItemSymbols;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Sensor;

import tools.jackson.core.JsonGenerator;
import tools.jackson.databind.json.JsonMapper;

import java.io.ByteArrayOutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.List;
import java.util.Optional;

/**
 * Encodes frames of the scene as binary messages to web pages. The script page/view.js reads them.
 * A message consists of these little-endian parts:
 *
 * <ul>
 *   <li>type (1), bytes of the structure, number of sections, number of slots;
 *   <li>frame and time as 64-bit floats;
 *   <li>the structure as JSON, padded to a multiple of 4 bytes;
 *   <li>for each section: column, number of bodies, their slots, their values as 32-bit floats.
 * </ul>
 *
 * <p>The structure lists items that entered or changed, and slots that are free. For one thread.
 */
final class SceneWriter {

    /** Type of a message with a frame. */
    static final int FRAME = 1;

    private static final int HEADER_BYTES = 32;
    private static final JsonMapper JSON = new JsonMapper();
    private static final SceneColumns[] COLUMNS = SceneColumns.values();
    private static final byte[] NONE = {};

    private final Optional<CameraDescription> camera;
    private int[] picked = {};

    /** The last encoded message. Watchers in the same state receive the same message. */
    private @Nullable ByteBuffer shared;

    private int sharedVersion;
    private int sharedSince;
    private int sharedColumns;

    /**
     * @param camera the first viewpoint, which only complete frames contain
     */
    SceneWriter(Optional<CameraDescription> camera) {
        this.camera = camera;
    }

    /**
     * Returns a message with the changes between an earlier version of the scene and the present
     * one. Several watchers may share it, so the caller must not change its position.
     *
     * @param since the earlier version, which the client has; if 0, the message contains everything
     * @param known optional columns that the client has in that version
     * @param wanted optional columns that it requests now
     */
    ByteBuffer write(Scene scene, int since, int known, int wanted) {
        int key = known << 8 | wanted;
        ByteBuffer last = shared;
        if (last == null
                || sharedVersion != scene.version()
                || sharedSince != since
                || sharedColumns != key) {
            last = encode(scene, since, known, wanted);
            shared = last;
            sharedVersion = scene.version();
            sharedSince = since;
            sharedColumns = key;
        }
        return last;
    }

    private ByteBuffer encode(Scene scene, int since, int known, int wanted) {
        byte[] structure = scene.hasNewStructure(since) ? structure(scene, since) : NONE;
        int padded = (structure.length + 3) & ~3;
        int slots = scene.slots();
        int[] counts = new int[COLUMNS.length];
        int bytes = HEADER_BYTES + padded;
        int sections = 0;
        if (picked.length < slots * COLUMNS.length) {
            picked = new int[slots * COLUMNS.length];
        }
        for (SceneColumns column : COLUMNS) {
            if (!column.isWanted(wanted)) {
                continue;
            }
            int from = column.isWanted(known) ? since : 0;
            int count = pick(scene, column, from, column.ordinal() * slots);
            counts[column.ordinal()] = count;
            if (count > 0) {
                sections++;
                bytes += 2 * Integer.BYTES + count * (1 + column.components()) * Float.BYTES;
            }
        }
        ByteBuffer out = ByteBuffer.allocate(bytes).order(ByteOrder.LITTLE_ENDIAN);
        out.putInt(FRAME).putInt(structure.length).putInt(sections).putInt(slots);
        out.putDouble(scene.frame()).putDouble(scene.time());
        out.put(structure).position(HEADER_BYTES + padded);
        for (SceneColumns column : COLUMNS) {
            int count = counts[column.ordinal()];
            if (count > 0) {
                put(out, scene, column, column.ordinal() * slots, count);
            }
        }
        return out.flip().asReadOnlyBuffer();
    }

    /** Collects the bodies whose value in a column has changed since a version. */
    private int pick(Scene scene, SceneColumns column, int since, int first) {
        if (!scene.hasChanged(column, since)) {
            return 0;
        }
        int count = 0;
        for (int slot = 0; slot < scene.slots(); slot++) {
            if (scene.hasChanged(column, slot, since)) {
                ItemSymbols item = scene.item(slot);
                if (item != null && item.kind().equals("body")) {
                    picked[first + count++] = slot;
                }
            }
        }
        return count;
    }

    private void put(ByteBuffer out, Scene scene, SceneColumns column, int first, int count) {
        int components = column.components();
        float[] values = scene.values(column);
        out.putInt(column.ordinal()).putInt(count);
        for (int i = 0; i < count; i++) {
            out.putInt(picked[first + i]);
        }
        for (int i = 0; i < count; i++) {
            int at = picked[first + i] * components;
            for (int component = 0; component < components; component++) {
                out.putFloat(values[at + component]);
            }
        }
    }

    private byte[] structure(Scene scene, int since) {
        var bytes = new ByteArrayOutputStream();
        try (JsonGenerator json = JSON.createGenerator(bytes)) {
            json.writeStartObject();
            if (since == 0 && camera.isPresent()) {
                write(json, camera.get());
            }
            if (since == 0 && scene.measuresContacts()) {
                json.writeBooleanProperty("measuresContacts", true);
            }
            json.writeArrayPropertyStart("items");
            for (int slot = 0; slot < scene.slots(); slot++) {
                ItemSymbols item = scene.item(slot);
                if (item != null && scene.hasNewStructure(slot, since)) {
                    write(json, scene, slot, item);
                }
            }
            json.writeEndArray();
            json.writeArrayPropertyStart("left");
            for (int slot = 0; since > 0 && slot < scene.slots(); slot++) {
                if (scene.item(slot) == null && scene.hasNewStructure(slot, since)) {
                    json.writeNumber(slot);
                }
            }
            json.writeEndArray();
            json.writeEndObject();
        }
        return bytes.toByteArray();
    }

    private static void write(JsonGenerator json, CameraDescription camera) {
        json.writeObjectPropertyStart("camera");
        write(json, "eye", camera.eye());
        write(json, "target", camera.target());
        write(json, "up", camera.up());
        json.writeNumberProperty("fov", camera.verticalFovRadians());
        json.writeEndObject();
    }

    private static void write(JsonGenerator json, String name, double[] numbers) {
        json.writeName(name);
        json.writeArray(numbers, 0, numbers.length);
    }

    private static void write(JsonGenerator json, Scene scene, int slot, ItemSymbols item) {
        json.writeStartObject();
        json.writeNumberProperty("slot", slot);
        json.writeStringProperty("name", item.name());
        json.writeStringProperty("kind", item.kind());
        item.get("class")
                .filter(is -> !is.equals(item.kind()))
                .ifPresent(is -> json.writeStringProperty("class", String.valueOf(is)));
        int shape = item.shape().code();
        if (shape != 0) {
            json.writeNumberProperty("shape", shape);
            if (item.shape() instanceof Mesh mesh) {
                json.writeNumberProperty("mesh", scene.assetId(mesh));
            }
            item.material().ifPresent(material -> write(json, scene, material));
        }
        item.look()
                .colour()
                .ifPresent(
                        colour ->
                                json.writeNumberProperty(
                                        "colour", Integer.toUnsignedLong(colour.rgba())));
        if (item.look().width() != 0) {
            json.writeNumberProperty("width", item.look().width());
        }
        writeSensors(json, item);
        int[] references = scene.references(slot);
        if (references.length > 0) {
            json.writeArrayPropertyStart("refers");
            for (int reference : references) {
                json.writeNumber(reference);
            }
            json.writeEndArray();
        }
        json.writeEndObject();
    }

    /** Writes the reach of the sensors that sense items, take pictures or hear. */
    private static void writeSensors(JsonGenerator json, ItemSymbols item) {
        List<Sensor> shown =
                item.sensors().stream()
                        .filter(sensor -> sensor.instrument().isEmpty() && !sensor.touch())
                        .toList();
        if (shown.isEmpty()) {
            return;
        }
        json.writeArrayPropertyStart("sensors");
        for (Sensor sensor : shown) {
            json.writeStartObject();
            json.writeStringProperty("name", sensor.name());
            if (Double.isFinite(sensor.range())) {
                json.writeNumberProperty("range", sensor.range());
            }
            json.writeNumberProperty("angle", sensor.fieldOfView());
            sensor.camera()
                    .ifPresent(
                            camera ->
                                    json.writeNumberProperty(
                                            "aspect", (double) camera.width() / camera.height()));
            json.writeEndObject();
        }
        json.writeEndArray();
    }

    private static void write(JsonGenerator json, Scene scene, Material material) {
        json.writeObjectPropertyStart("material");
        json.writeNumberProperty("colour", Integer.toUnsignedLong(material.colour().rgba()));
        json.writeNumberProperty("roughness", material.roughness());
        json.writeNumberProperty("metallic", material.metallic());
        material.texture()
                .ifPresent(texture -> json.writeNumberProperty("texture", scene.assetId(texture)));
        json.writeEndObject();
    }
}
