// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import org.jspecify.annotations.Nullable;

import reve.core.disk.WholeFile;
import reve.core.frame.Timing;
import reve.core.world.ColumnView;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;
import reve.worlds.Product;

import java.io.IOException;
import java.nio.file.Path;
import java.util.Base64;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * A file in the MCAP format with messages in JSON, which Foxglove and other programs show. The time
 * of a message is the number of its frame divided by the frame rate, so it also increases after a
 * rewind. Topics:
 *
 * <ul>
 *   <li>{@code /tf}: place and rotation of each body in the reference frame {@code world}, and that
 *       frame in {@code z-up}, whose third axis is up;
 *   <li>{@code /scene}: shapes and colours of all bodies, whenever one changes, and regularly, so
 *       that a program can begin anywhere in the file;
 *   <li>{@code /connections}: springs and surfaces;
 *   <li>{@code /log}: events;
 *   <li>{@code /picture}: pictures that the caller drew;
 *   <li>{@code /properties/KIND}: all properties of the items of a kind.
 * </ul>
 */
public final class McapExport implements Export {
    /** Text with which each file begins. */
    public static final String MARK = "MCAP0";

    private static final long SECOND_NANOS = 1_000_000_000L;
    private static final int INFO = 2;
    private static final int WARNING = 3;
    private static final int ERROR = 4;
    private static final Set<String> WARNINGS = Set.of("late", "away", "over-budget", "stalled");

    /** The rotation by 90° about the x axis, as a quaternion xyzw. It turns +Y to +Z. */
    private static final double[] Y_TO_Z = {Math.sqrt(0.5), 0, 0, Math.sqrt(0.5)};

    private final WholeFile file;
    private final McapWriter writer;
    private final String world;
    private final Timing timing;
    private final List<String> kinds;
    private final Map<String, Integer> properties = new LinkedHashMap<>();
    private final SceneMessages scene = new SceneMessages();
    private final int transforms;
    private final int shapes;
    private final int connections;
    private final int log;

    /** Number of the channel for pictures; 0 before the first picture. */
    private int pictures;

    /**
     * Creates the file.
     *
     * @param world name of the world
     * @param kinds the kinds of items whose properties are written
     * @throws IOException if the file cannot be created
     */
    public McapExport(
            Path place,
            String world,
            WorldPrototype prototype,
            Timing timing,
            Collection<String> kinds)
            throws IOException {
        this.world = world;
        this.timing = timing;
        this.kinds = List.copyOf(kinds);
        file = new WholeFile(place);
        try {
            writer = new McapWriter(file.out(), "REVE x Vesper " + Product.version());
            Map<String, String> about = new LinkedHashMap<>();
            about.put("world", world);
            about.put("prototype", prototype.name());
            about.put("framesPerSecond", Integer.toString(timing.framesPerSecond()));
            about.put("stepsPerFrame", Integer.toString(timing.stepsPerFrame()));
            writer.metadata("reve", about);
            byte[] update = Schemas.sceneUpdate();
            transforms = channel("/tf", "foxglove.FrameTransforms", Schemas.frameTransforms());
            shapes = channel("/scene", "foxglove.SceneUpdate", update);
            connections = channel("/connections", "foxglove.SceneUpdate", update);
            log = channel("/log", "foxglove.Log", Schemas.log());
        } catch (IOException | RuntimeException e) {
            file.close();
            throw e;
        }
    }

    private int channel(String topic, String schemaName, byte[] schema) {
        return writer.channel(topic, schemaName, schema, Map.of());
    }

    @Override
    public void add(ExportedFrame frame) throws IOException {
        WorldSnapshot snapshot = frame.snapshot();
        long nanos = nanos(snapshot.frame());
        writer.message(transforms, nanos, transforms(snapshot, nanos));
        write(shapes, nanos, scene.shapes(snapshot, nanos));
        write(connections, nanos, scene.connections(snapshot, nanos));
        for (ExportedFrame.Event event : frame.events()) {
            writer.message(log, nanos, line(event, nanos));
        }
        for (TableSnapshot table : snapshot.tables()) {
            if (kinds.contains(table.kind())) {
                int channel =
                        properties.computeIfAbsent(
                                table.kind(),
                                kind ->
                                        channel(
                                                "/properties/" + kind,
                                                "reve.Properties." + kind,
                                                Schemas.properties(table)));
                writer.message(channel, nanos, properties(table, snapshot, nanos));
            }
        }
    }

    /**
     * Adds a picture of a frame, after the frame.
     *
     * @throws IOException if it cannot be written
     */
    public void addPicture(long frame, byte[] png) throws IOException {
        if (pictures == 0) {
            pictures = channel("/picture", "foxglove.CompressedImage", Schemas.compressedImage());
        }
        long nanos = nanos(frame);
        writer.message(
                pictures,
                nanos,
                new JsonText()
                        .time("timestamp", nanos)
                        .put("frame_id", "picture")
                        .put("data", Base64.getEncoder().encodeToString(png))
                        .put("format", "png")
                        .done());
    }

    private void write(int channel, long nanos, byte @Nullable [] message) throws IOException {
        if (message != null) {
            writer.message(channel, nanos, message);
        }
    }

    /**
     * Returns the time of a frame [ns]. The full seconds and the remaining frames are converted
     * separately, because a single product may be too large for a long.
     */
    private long nanos(long frame) {
        long rate = timing.framesPerSecond();
        return frame / rate * SECOND_NANOS + frame % rate * SECOND_NANOS / rate;
    }

    private static byte[] transforms(WorldSnapshot snapshot, long nanos) {
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        ColumnView position = bodies.column("position");
        ColumnView orientation = bodies.column("orientation");
        JsonText text = new JsonText().beginList("transforms");
        begin(text, nanos, SceneMessages.Z_UP, SceneMessages.WORLD)
                .vector("translation", 0, 0, 0)
                .vector("rotation", Y_TO_Z)
                .end();
        for (int row = 0; row < bodies.rowCount(); row++) {
            String name = snapshot.symbols().get(bodies.idAt(row)).name();
            begin(text, nanos, SceneMessages.WORLD, SceneMessages.frameOf(name));
            vector(text, "translation", position, row, snapshot);
            vector(text, "rotation", orientation, row, snapshot);
            text.end();
        }
        return text.endList().done();
    }

    private static JsonText begin(JsonText text, long nanos, String parent, String child) {
        return text.begin()
                .time("timestamp", nanos)
                .put("parent_frame_id", parent)
                .put("child_frame_id", child);
    }

    private static void vector(
            JsonText text, String name, ColumnView column, int row, WorldSnapshot snapshot) {
        List<String> components = Properties.components(column.descriptor());
        boolean isText = Properties.isText(column.descriptor());
        boolean single = components.size() == 1;
        if (!single) {
            text.begin(name);
        }
        for (int i = 0; i < components.size(); i++) {
            String label = single ? name : components.get(i);
            if (isText) {
                text.put(label, Properties.text(column, row, i, snapshot));
            } else {
                text.digits(label, Properties.number(column, row, i));
            }
        }
        if (!single) {
            text.end();
        }
    }

    private byte[] line(ExportedFrame.Event event, long nanos) {
        StringBuilder message = new StringBuilder(event.type());
        event.fields()
                .forEach(
                        (name, value) ->
                                message.append(' ').append(name).append('=').append(value));
        int level =
                event.type().equals("fault")
                        ? ERROR
                        : WARNINGS.contains(event.type()) ? WARNING : INFO;
        return new JsonText()
                .time("timestamp", nanos)
                .put("level", level)
                .put("message", message.toString())
                .put("name", world)
                .put("file", "")
                .put("line", 0)
                .done();
    }

    private static byte[] properties(TableSnapshot table, WorldSnapshot snapshot, long nanos) {
        JsonText text =
                new JsonText()
                        .time("timestamp", nanos)
                        .put("frame", snapshot.frame())
                        .put("time", snapshot.timeSeconds())
                        .beginList("items");
        List<? extends ColumnView> columns = table.columns();
        for (int row = 0; row < table.rowCount(); row++) {
            text.begin()
                    .put("id", table.idAt(row).value())
                    .put("name", snapshot.symbols().get(table.idAt(row)).name());
            for (ColumnView column : columns) {
                vector(text, column.name(), column, row, snapshot);
            }
            text.end();
        }
        return text.endList().done();
    }

    @Override
    public void finish() throws IOException {
        writer.finish();
        file.finish();
    }

    @Override
    public void close() throws IOException {
        file.close();
    }
}
