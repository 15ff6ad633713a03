// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.hull.ConvexHull;
import reve.core.world.Column;
import reve.core.world.ColumnArena;
import reve.core.world.Mesh;
import reve.core.world.Shape;
import reve.core.world.Table;
import reve.core.world.World;

import java.lang.foreign.MemorySegment;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.nio.IntBuffer;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The meshes of a world's bodies and scenery, with their convex hulls, in the memory of the engine.
 * Equal meshes have one row. The rows are in the order of the items, so that they depend on the
 * state of the world only. For the world's thread only.
 */
final class BoundMeshes {
    /** Count of numbers in a row of {@code meshRanges}; see the engine's standard prototype. */
    private static final int RANGES = 10;

    private final World world;
    private final Table bodies;
    private final Column shapes;
    private final ColumnArena arena;

    /** The row of each mesh; equal meshes have the same row. */
    private final Map<Mesh, Integer> rows = new IdentityHashMap<>();

    /** The content of each mesh, with its hash. */
    private final Map<Mesh, Content> contents = new IdentityHashMap<>();

    private List<Mesh> meshes = List.of();
    private long seen = -1;
    private @Nullable MemorySegment ranges;
    private @Nullable MemorySegment points;
    private @Nullable MemorySegment indices;
    private int pointCount;
    private int indexCount;

    BoundMeshes(World world, Table bodies, ColumnArena arena) {
        this.world = world;
        this.bodies = bodies;
        this.arena = arena;
        shapes = bodies.column("shape");
    }

    boolean isEmpty() {
        return meshes.isEmpty();
    }

    /**
     * Reads the shapes of all items, if items or shapes have changed.
     *
     * @return whether the engine needs other meshes
     */
    boolean follow(boolean moved) {
        if (!moved && shapes.version() == seen) {
            return false;
        }
        seen = shapes.version();
        Map<Content, Integer> byContent = new HashMap<>();
        List<Mesh> found = new ArrayList<>();
        rows.clear();
        for (int row = 0; row < bodies.rowCount(); row++) {
            mesh(row).ifPresent(mesh -> addRow(mesh, byContent, found));
        }
        contents.keySet().retainAll(rows.keySet());
        if (isSame(found)) {
            return false;
        }
        meshes = found;
        write();
        return true;
    }

    private void addRow(Mesh mesh, Map<Content, Integer> byContent, List<Mesh> found) {
        if (rows.containsKey(mesh)) {
            return;
        }
        Content content = contents.computeIfAbsent(mesh, Content::new);
        Integer equal = byContent.putIfAbsent(content, found.size());
        rows.put(mesh, equal == null ? found.size() : equal);
        if (equal == null) {
            found.add(mesh);
        }
    }

    private boolean isSame(List<Mesh> found) {
        if (found.size() != meshes.size()) {
            return false;
        }
        for (int i = 0; i < found.size(); i++) {
            if (found.get(i) != meshes.get(i)) {
                return false;
            }
        }
        return true;
    }

    private Optional<Mesh> mesh(int tableRow) {
        return shapes.getInt(tableRow, 0) == Shape.MESH
                        && world.item(bodies.idAt(tableRow)).physical().shape() instanceof Mesh mesh
                ? Optional.of(mesh)
                : Optional.empty();
    }

    /** A mesh that equals every mesh with the same vertices and triangles. */
    private static final class Content {
        private final Mesh mesh;
        private final int hash;

        Content(Mesh mesh) {
            this.mesh = mesh;
            hash = 31 * mesh.vertices().hashCode() + mesh.triangles().hashCode();
        }

        @Override
        public boolean equals(@Nullable Object other) {
            return other instanceof Content content
                    && hash == content.hash
                    && (mesh == content.mesh
                            || mesh.vertices().equals(content.mesh.vertices())
                                    && mesh.triangles().equals(content.mesh.triangles()));
        }

        @Override
        public int hashCode() {
            return hash;
        }
    }

    /** Writes all meshes and their hulls. The caller must rebind them before the engine runs. */
    private void write() {
        pointCount = 0;
        indexCount = 0;
        for (Mesh mesh : meshes) {
            Optional<ConvexHull> hull = mesh.hull();
            pointCount +=
                    mesh.vertices().remaining() / 3
                            + hull.map(h -> (h.corners().length + h.core().length) / 3).orElse(0);
            indexCount +=
                    mesh.triangles().remaining() + hull.map(BoundMeshes::faceNumbers).orElse(0);
        }
        ranges = roomFor(ranges, "meshRanges", (long) meshes.size() * RANGES * Integer.BYTES);
        points = roomFor(points, "meshPoints", 3L * pointCount * Double.BYTES);
        indices = roomFor(indices, "meshIndices", (long) indexCount * Integer.BYTES);
        IntBuffer range = ranges.asByteBuffer().order(ByteOrder.nativeOrder()).asIntBuffer();
        DoubleBuffer point = points.asByteBuffer().order(ByteOrder.nativeOrder()).asDoubleBuffer();
        IntBuffer index = indices.asByteBuffer().order(ByteOrder.nativeOrder()).asIntBuffer();
        for (Mesh mesh : meshes) {
            write(mesh, range, point, index);
        }
    }

    private static int faceNumbers(ConvexHull hull) {
        int count = 0;
        for (int[] face : hull.faces()) {
            count += 1 + face.length;
        }
        return count;
    }

    private static void write(Mesh mesh, IntBuffer range, DoubleBuffer point, IntBuffer index) {
        ConvexHull hull = mesh.hull().orElse(null);
        range.put(point.position() / 3).put(hull == null ? 0 : hull.corners().length / 3);
        if (hull != null) {
            point.put(hull.corners());
        }
        range.put(point.position() / 3).put(hull == null ? 0 : hull.core().length / 3);
        range.put(index.position()).put(hull == null ? 0 : faceNumbers(hull));
        if (hull != null) {
            point.put(hull.core());
            for (int[] face : hull.faces()) {
                index.put(face.length).put(face);
            }
        }
        range.put(point.position() / 3).put(mesh.vertices().remaining() / 3);
        for (var vertices = mesh.vertices(); vertices.hasRemaining(); ) {
            point.put(vertices.get());
        }
        range.put(index.position()).put(mesh.triangles().remaining());
        index.put(mesh.triangles());
    }

    private MemorySegment roomFor(@Nullable MemorySegment old, String name, long bytes) {
        if (old != null && old.byteSize() >= bytes) {
            return old;
        }
        if (old != null) {
            arena.release(old);
        }
        return arena.reserve("body." + name, Math.max(1, bytes));
    }

    /** Returns the property of the engine with this name and kind. */
    BoundProperty property(String name, String kind, boolean scenery) {
        return switch (kind) {
            case PropertyNames.MESH_FORM, PropertyNames.MESH_POINT, PropertyNames.MESH_INDEX ->
                    new Data(this, name, kind);
            default -> new Rows(this, name, scenery);
        };
    }

    /** The property that contains, for each row of bodies or scenery, the row of the mesh. */
    static final class Rows extends BoundRowNumbers {
        private final BoundMeshes meshes;
        private long seen = -1;

        private Rows(BoundMeshes meshes, String name, boolean scenery) {
            super(name, meshes.bodies, scenery, meshes.arena);
            this.meshes = meshes;
        }

        @Override
        int numberOf(int tableRow) {
            return meshes.mesh(tableRow).map(meshes.rows::get).orElse(NONE);
        }

        @Override
        boolean isEdited() {
            return meshes.shapes.version() != seen;
        }

        @Override
        void markSeen() {
            seen = meshes.shapes.version();
        }
    }

    /** The properties of the meshes themselves, which are separate kinds with their own rows. */
    static final class Data extends BoundProperty {
        private final BoundMeshes meshes;
        private final String kind;

        private Data(BoundMeshes meshes, String name, String kind) {
            super(name, meshes.bodies, false);
            this.meshes = meshes;
            this.kind = kind;
        }

        @Override
        int rowCount() {
            return switch (kind) {
                case PropertyNames.MESH_FORM -> meshes.meshes.size();
                case PropertyNames.MESH_POINT -> meshes.pointCount;
                default -> meshes.indexCount;
            };
        }

        @Override
        MemorySegment memory() {
            MemorySegment memory =
                    switch (kind) {
                        case PropertyNames.MESH_FORM -> meshes.ranges;
                        case PropertyNames.MESH_POINT -> meshes.points;
                        default -> meshes.indices;
                    };
            if (memory == null) {
                throw new IllegalStateException("the world has no meshes");
            }
            return memory;
        }

        @Override
        boolean isEdited() {
            return false;
        }

        @Override
        void markSeen() {}
    }
}
