// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import org.jspecify.annotations.Nullable;

import reve.core.world.Colour;
import reve.core.world.ColumnView;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Shape;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;

/**
 * The messages that describe shapes. Bodies are described in their own reference frames, which
 * move. Springs and surfaces are described in the reference frame of the world. Each message
 * contains everything, so a program that begins at any message shows the whole scene. For one
 * thread.
 */
final class SceneMessages {
    /** Reference frame of the world, with +Y up. */
    static final String WORLD = "world";

    /** Reference frame whose third axis is up. */
    static final String Z_UP = "z-up";

    private static final Set<String> RESERVED = Set.of(WORLD, Z_UP);
    private static final long SECOND_NANOS = 1_000_000_000L;
    private static final int SMALL_BYTES = 1 << 16;
    private static final long LARGE_EVERY_NANOS = 10 * SECOND_NANOS;
    private static final double[] NO_MOVE = {0, 0, 0};
    private static final double[] NO_TURN = {0, 0, 0, 1};

    /**
     * The rotation by -90° about the x axis, as a quaternion xyzw. It turns +Z, the axis of
     * cylinders, to +Y.
     */
    private static final double[] Z_TO_Y = {-Math.sqrt(0.5), 0, 0, Math.sqrt(0.5)};

    private static final double PLANE_THICKNESS = 1e-3;
    private static final int LINE_LIST = 2;
    private static final double LINE_PIXELS = 2;

    private Map<String, Look> shown = Map.of();
    private long shownNanos;
    private int shownBytes;
    private boolean anyConnections;

    /** The appearance of a body, with which the appearance in the next frame is compared. */
    private record Look(Shape shape, Optional<Material> material, int rgba) {}

    /** A spring or a surface, with the rows of its bodies. */
    private record Connection(ConnectionLook look, int[] rows) {}

    /** Returns the name of a body's reference frame, which is the name of the body. */
    static String frameOf(String body) {
        return RESERVED.contains(body) ? "body " + body : body;
    }

    /**
     * Returns the message with the shapes of all bodies. Returns null if the last message is still
     * correct.
     */
    byte @Nullable [] shapes(WorldSnapshot snapshot, long nanos) {
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        ColumnView colour = bodies.column("colour");
        Map<String, Look> looks = new LinkedHashMap<>();
        for (int row = 0; row < bodies.rowCount(); row++) {
            ItemSymbols item = snapshot.symbols().get(bodies.idAt(row));
            int rgba = colour.getInt(row, 0);
            if (item.shape() != Shape.none() && rgba >>> 24 != 0) {
                looks.put(item.name(), new Look(item.shape(), item.material(), rgba));
            }
        }
        long every = shownBytes <= SMALL_BYTES ? SECOND_NANOS : LARGE_EVERY_NANOS;
        if (looks.equals(shown) && nanos < shownNanos + every) {
            return null;
        }
        JsonText text = new JsonText().beginList("deletions");
        Set<String> gone = new LinkedHashSet<>(shown.keySet());
        gone.removeAll(looks.keySet());
        for (String name : gone) {
            text.begin().time("timestamp", nanos).put("type", 0).put("id", name).end();
        }
        text.endList().beginList("entities");
        looks.forEach((name, look) -> entity(text, name, look, nanos));
        byte[] message = text.endList().done();
        shown = looks;
        shownNanos = nanos;
        shownBytes = message.length;
        return message;
    }

    private static JsonText begin(JsonText text, String frame, String id, long nanos) {
        return text.begin()
                .time("timestamp", nanos)
                .put("frame_id", frame)
                .put("id", id)
                .time("lifetime", 0)
                .put("frame_locked", true);
    }

    private static void entity(JsonText text, String name, Look look, long nanos) {
        begin(text, frameOf(name), name, nanos);
        int rgba = tinted(look.rgba(), look.material());
        switch (look.shape()) {
            case Shape.None _ -> {}
            case Shape.Sphere ball -> {
                text.beginList("spheres");
                sized(text, NO_MOVE, NO_TURN, extents(ball), rgba).end().endList();
            }
            case Shape.Ellipsoid round -> {
                text.beginList("spheres");
                sized(text, NO_MOVE, NO_TURN, extents(round), rgba).end().endList();
            }
            case Shape.Box box -> {
                text.beginList("cubes");
                sized(text, NO_MOVE, NO_TURN, extents(box), rgba).end().endList();
            }
            case Shape.Plane plane -> {
                double[] place = {0, -PLANE_THICKNESS / 2, 0};
                double[] size = {plane.x(), PLANE_THICKNESS, plane.z()};
                text.beginList("cubes");
                sized(text, place, NO_TURN, size, rgba).end().endList();
            }
            case Shape.Cylinder round -> {
                text.beginList("cylinders");
                tube(text, round.radius(), round.height(), rgba);
                text.endList();
            }
            case Shape.Capsule capsule -> {
                double middle = capsule.height() - 2 * capsule.radius();
                text.beginList("cylinders");
                tube(text, capsule.radius(), middle, rgba);
                text.endList().beginList("spheres");
                double across = 2 * capsule.radius();
                double[] size = {across, across, across};
                for (double end : new double[] {-middle / 2, middle / 2}) {
                    sized(text, new double[] {0, end, 0}, NO_TURN, size, rgba).end();
                }
                text.endList();
            }
            case Mesh mesh -> {
                text.beginList("triangles");
                if (look.material().isPresent() || mesh.parts().isEmpty()) {
                    triangles(text, mesh, 0, mesh.triangles().remaining() / 3, rgba);
                } else {
                    for (Mesh.Part part : mesh.parts()) {
                        triangles(
                                text,
                                mesh,
                                part.firstTriangle(),
                                part.triangleCount(),
                                tinted(look.rgba(), Optional.of(part.material())));
                    }
                }
                text.endList();
            }
        }
        text.end();
    }

    private static double[] extents(Shape shape) {
        return new double[] {shape.size(0), shape.size(1), shape.size(2)};
    }

    /** Begins a primitive with pose, size and colour. */
    private static JsonText sized(
            JsonText text, double[] place, double[] turn, double[] size, int rgba) {
        return pose(text.begin(), place, turn).vector("size", size).colour("color", rgba);
    }

    private static JsonText pose(JsonText text, double[] place, double[] turn) {
        return text.begin("pose").vector("position", place).vector("orientation", turn).end();
    }

    private static void tube(JsonText text, double radius, double height, int rgba) {
        double[] size = {2 * radius, 2 * radius, height};
        sized(text, NO_MOVE, Z_TO_Y, size, rgba)
                .put("bottom_scale", 1.0)
                .put("top_scale", 1.0)
                .end();
    }

    private static void triangles(JsonText text, Mesh mesh, int first, int count, int rgba) {
        IntBuffer corners = mesh.triangles();
        FloatBuffer vertices = mesh.vertices();
        Optional<IntBuffer> colours = mesh.colours();
        pose(text.begin(), NO_MOVE, NO_TURN).beginList("points");
        for (int i = 3 * first; i < 3 * (first + count); i++) {
            int at = 3 * corners.get(i);
            point(text, vertices.get(at), vertices.get(at + 1), vertices.get(at + 2));
        }
        text.endList().colour("color", rgba).beginList("colors");
        if (colours.isPresent()) {
            for (int i = 3 * first; i < 3 * (first + count); i++) {
                corner(text, product(colours.get().get(corners.get(i)), rgba));
            }
        }
        text.endList().beginList("indices").endList().end();
    }

    private static void point(JsonText text, double x, double y, double z) {
        text.begin().put("x", x).put("y", y).put("z", z).end();
    }

    private static void corner(JsonText text, int rgba) {
        text.begin();
        text.channels(rgba);
        text.end();
    }

    private static int tinted(int rgba, Optional<Material> material) {
        return material.map(Material::colour)
                .map(Colour::rgba)
                .map(own -> product(own, rgba))
                .orElse(rgba);
    }

    private static int product(int one, int other) {
        int product = 0;
        for (int shift = 0; shift < 32; shift += 8) {
            product |=
                    Math.round((one >>> shift & 0xff) * (other >>> shift & 0xff) / 255f) << shift;
        }
        return product;
    }

    /**
     * Returns the message with the springs and surfaces. Returns null if there are none and the
     * last frame had none.
     */
    byte @Nullable [] connections(WorldSnapshot snapshot, long nanos) {
        TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
        // The springs by width. Those without a width are always the first ones.
        Map<Double, List<Connection>> lines = new TreeMap<>();
        lines.put(0.0, new ArrayList<>());
        List<Connection> triangles = new ArrayList<>();
        for (TableSnapshot table : snapshot.tables()) {
            for (int row = 0; row < table.rowCount(); row++) {
                ConnectionLook look = snapshot.symbols().get(table.idAt(row)).look();
                if (look.isHidden()) {
                    continue;
                }
                if (table.kind().equals(WorldPrototype.SPRING)) {
                    addIfWhole(
                            lines.computeIfAbsent(look.width(), width -> new ArrayList<>()),
                            look,
                            rowOf(bodies, table.column("end1"), row, 0),
                            rowOf(bodies, table.column("end2"), row, 0));
                } else if (table.kind().equals(WorldPrototype.SURFACE)) {
                    ColumnView vertices = table.column("vertices");
                    addIfWhole(
                            triangles,
                            look,
                            rowOf(bodies, vertices, row, 0),
                            rowOf(bodies, vertices, row, 1),
                            rowOf(bodies, vertices, row, 2));
                }
            }
        }
        boolean any =
                lines.values().stream().anyMatch(all -> !all.isEmpty()) || !triangles.isEmpty();
        if (!any && !anyConnections) {
            return null;
        }
        anyConnections = any;
        JsonText text = new JsonText().beginList("deletions").endList().beginList("entities");
        begin(text, WORLD, "connections", nanos).beginList("lines");
        lines.forEach((width, springs) -> lines(text, bodies, width, springs));
        text.endList().beginList("triangles");
        if (!triangles.isEmpty()) {
            ColumnView colour = bodies.column("colour");
            pose(text.begin(), NO_MOVE, NO_TURN).beginList("points");
            corners(text, bodies, triangles);
            text.endList().colour("color", Colour.DEFAULT.rgba()).beginList("colors");
            triangles.forEach(
                    surface -> {
                        for (int row : surface.rows()) {
                            int rgba =
                                    surface.look()
                                            .colour()
                                            .map(Colour::rgba)
                                            .orElseGet(() -> colour.getInt(row, 0));
                            corner(text, rgba | 0xff000000);
                        }
                    });
            text.endList().beginList("indices").endList().end();
        }
        return text.endList().end().endList().done();
    }

    /** The springs of one width. Their message has a colour for each point if a spring sets one. */
    private static void lines(
            JsonText text, TableSnapshot bodies, double width, List<Connection> springs) {
        pose(text.begin().put("type", LINE_LIST), NO_MOVE, NO_TURN)
                .put("thickness", width == 0 ? LINE_PIXELS : width)
                .put("scale_invariant", width == 0)
                .beginList("points");
        corners(text, bodies, springs);
        text.endList().colour("color", ConnectionLook.SPRING_COLOUR.rgba()).beginList("colors");
        if (springs.stream().anyMatch(spring -> spring.look().colour().isPresent())) {
            for (Connection spring : springs) {
                int rgba = spring.look().colour().orElse(ConnectionLook.SPRING_COLOUR).rgba();
                corner(text, rgba);
                corner(text, rgba);
            }
        }
        text.endList().beginList("indices").endList().end();
    }

    private static void addIfWhole(List<Connection> all, ConnectionLook look, int... rows) {
        for (int row : rows) {
            if (row < 0) {
                return;
            }
        }
        all.add(new Connection(look, rows));
    }

    private static void corners(JsonText text, TableSnapshot bodies, List<Connection> all) {
        ColumnView position = bodies.column("position");
        for (Connection connection : all) {
            for (int row : connection.rows()) {
                point(
                        text,
                        position.getDouble(row, 0),
                        position.getDouble(row, 1),
                        position.getDouble(row, 2));
            }
        }
    }

    private static int rowOf(TableSnapshot bodies, ColumnView references, int row, int which) {
        long id = references.getReference(row, which);
        return id > 0 ? bodies.rowOf(new ItemId(id)) : -1;
    }
}
