// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import reve.core.world.ColumnView;
import reve.core.world.TableSnapshot;

import tools.jackson.databind.json.JsonMapper;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The JSON schemas of the messages in MCAP files. Schemas with names of Foxglove contain only those
 * fields of Foxglove's schemas that this project writes.
 */
final class Schemas {
    private static final JsonMapper JSON = new JsonMapper();

    private static final Map<String, Object> NUMBER = type("number");
    private static final Map<String, Object> INTEGER = type("integer");
    private static final Map<String, Object> TEXT = type("string");
    private static final Map<String, Object> TRUTH = type("boolean");
    private static final Map<String, Object> TIME =
            object("time", fields("sec", INTEGER, "nsec", INTEGER));
    private static final Map<String, Object> DURATION =
            object("duration", fields("sec", INTEGER, "nsec", INTEGER));
    private static final Map<String, Object> VECTOR = numbers("foxglove.Vector3", "x", "y", "z");
    private static final Map<String, Object> POINT = numbers("foxglove.Point3", "x", "y", "z");
    private static final Map<String, Object> QUATERNION =
            numbers("foxglove.Quaternion", "x", "y", "z", "w");
    private static final Map<String, Object> COLOUR = numbers("foxglove.Color", "r", "g", "b", "a");
    private static final Map<String, Object> POSE =
            object("foxglove.Pose", fields("position", VECTOR, "orientation", QUATERNION));

    private Schemas() {}

    /** Returns the schema of places and rotations. */
    static byte[] frameTransforms() {
        Map<String, Object> transform =
                object(
                        "foxglove.FrameTransform",
                        fields(
                                "timestamp",
                                TIME,
                                "parent_frame_id",
                                TEXT,
                                "child_frame_id",
                                TEXT,
                                "translation",
                                VECTOR,
                                "rotation",
                                QUATERNION));
        return bytes(object("foxglove.FrameTransforms", fields("transforms", list(transform))));
    }

    /** Returns the schema of shapes. */
    static byte[] sceneUpdate() {
        Map<String, Object> deletion =
                object(
                        "foxglove.SceneEntityDeletion",
                        fields("timestamp", TIME, "type", INTEGER, "id", TEXT));
        Map<String, Object> sized = fields("pose", POSE, "size", VECTOR, "color", COLOUR);
        Map<String, Object> cylinder =
                fields(
                        "pose",
                        POSE,
                        "size",
                        VECTOR,
                        "bottom_scale",
                        NUMBER,
                        "top_scale",
                        NUMBER,
                        "color",
                        COLOUR);
        Map<String, Object> line = fields("type", INTEGER, "pose", POSE, "thickness", NUMBER);
        line.putAll(fields("scale_invariant", TRUTH, "points", list(POINT), "color", COLOUR));
        line.putAll(fields("colors", list(COLOUR), "indices", list(INTEGER)));
        Map<String, Object> triangles =
                fields("pose", POSE, "points", list(POINT), "color", COLOUR);
        triangles.putAll(fields("colors", list(COLOUR), "indices", list(INTEGER)));
        Map<String, Object> pair =
                object("foxglove.KeyValuePair", fields("key", TEXT, "value", TEXT));
        Map<String, Object> entity = fields("timestamp", TIME, "frame_id", TEXT, "id", TEXT);
        entity.putAll(fields("lifetime", DURATION, "frame_locked", TRUTH, "metadata", list(pair)));
        entity.put("cubes", list(object("foxglove.CubePrimitive", sized)));
        entity.put("spheres", list(object("foxglove.SpherePrimitive", sized)));
        entity.put("cylinders", list(object("foxglove.CylinderPrimitive", cylinder)));
        entity.put("lines", list(object("foxglove.LinePrimitive", line)));
        entity.put("triangles", list(object("foxglove.TriangleListPrimitive", triangles)));
        return bytes(
                object(
                        "foxglove.SceneUpdate",
                        fields(
                                "deletions",
                                list(deletion),
                                "entities",
                                list(object("foxglove.SceneEntity", entity)))));
    }

    /** Returns the schema of log lines. */
    static byte[] log() {
        Map<String, Object> fields = fields("timestamp", TIME, "level", INTEGER, "message", TEXT);
        fields.putAll(fields("name", TEXT, "file", TEXT, "line", INTEGER));
        return bytes(object("foxglove.Log", fields));
    }

    /** Returns the schema of pictures. */
    static byte[] compressedImage() {
        Map<String, Object> data = fields("type", "string", "contentEncoding", "base64");
        return bytes(
                object(
                        "foxglove.CompressedImage",
                        fields("timestamp", TIME, "frame_id", TEXT, "data", data, "format", TEXT)));
    }

    /** Returns the schema of the properties of a kind, with their units. */
    static byte[] properties(TableSnapshot table) {
        Map<String, Object> item = fields("id", INTEGER, "name", TEXT);
        for (ColumnView column : table.columns()) {
            Map<String, Object> one = Properties.isText(column.descriptor()) ? TEXT : NUMBER;
            List<String> components = Properties.components(column.descriptor());
            Map<String, Object> value = new LinkedHashMap<>(one);
            if (components.size() > 1) {
                Map<String, Object> parts = new LinkedHashMap<>();
                components.forEach(component -> parts.put(component, one));
                value = new LinkedHashMap<>(object(column.name(), parts));
            }
            if (!Properties.isText(column.descriptor())) {
                value.put("description", "[" + column.unit().symbol() + "]");
            }
            item.put(column.name(), value);
        }
        Map<String, Object> all = fields("timestamp", TIME, "frame", INTEGER, "time", NUMBER);
        all.put("items", list(object(table.kind(), item)));
        return bytes(object("reve.Properties." + table.kind(), all));
    }

    private static Map<String, Object> type(String name) {
        return Map.of("type", name);
    }

    private static Map<String, Object> list(Map<String, Object> item) {
        return fields("type", "array", "items", item);
    }

    private static Map<String, Object> numbers(String title, String... names) {
        Map<String, Object> fields = new LinkedHashMap<>();
        for (String name : names) {
            fields.put(name, NUMBER);
        }
        return object(title, fields);
    }

    private static Map<String, Object> object(String title, Map<String, Object> fields) {
        return fields("title", title, "type", "object", "properties", fields);
    }

    /** Returns a map of names and values, alternating, in the order given. */
    private static Map<String, Object> fields(Object... namesAndValues) {
        Map<String, Object> fields = new LinkedHashMap<>();
        for (int i = 0; i < namesAndValues.length; i += 2) {
            fields.put((String) namesAndValues[i], namesAndValues[i + 1]);
        }
        return fields;
    }

    private static byte[] bytes(Map<String, Object> schema) {
        return JSON.writeValueAsBytes(schema);
    }
}
