package reve.core.mesh;

import de.javagl.obj.FloatTuple;
import de.javagl.obj.Mtl;
import de.javagl.obj.MtlReader;
import de.javagl.obj.Obj;
import de.javagl.obj.ObjFace;
import de.javagl.obj.ObjReader;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;
import org.jspecify.annotations.Nullable;
import reve.core.world.Colour;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Texture;

/**
 * Wavefront OBJ to one mesh: all faces, split into triangles around their first corner, in metres.
 * Of its material libraries: diffuse colour and texture, and the roughness and metallic of those
 * that say so.
 */
final class ObjMeshReader {

    private static final int MAX_LIBRARY_BYTES = 1 << 20;
    private static final int MAX_GROUPS = 65_536;

    private final Obj obj;
    private final Sources sources;
    private final MeshAssembler mesh;
    private final Map<String, Material> materials = new HashMap<>();
    private final Map<Corner, Integer> vertices = new HashMap<>();
    /** Of the face that is being read. */
    private Material material = Material.DEFAULT;

    /** Which of the file's positions, texture coordinates and normals a vertex has; -1 for none. */
    private record Corner(int position, int coordinates, int normal) {}

    private ObjMeshReader(Obj obj, Sources sources) {
        this.obj = obj;
        this.sources = sources;
        this.mesh = new MeshAssembler(sources);
    }

    static Mesh read(byte[] bytes, Sources sources) throws AssetException {
        checkSize(bytes, sources);
        try {
            return new ObjMeshReader(ObjReader.read(new ByteArrayInputStream(bytes)), sources)
                    .read();
        } catch (IOException | RuntimeException broken) {
            // The library answers some broken files with unchecked exceptions.
            throw sources.refuse("not OBJ: " + ObjLines.fault(bytes)
                    .orElse("its lines do not fit together"));
        }
    }

    /** Counts lines by what they begin with, which bounds what the library makes of them. */
    private static void checkSize(byte[] bytes, Sources sources) throws AssetException {
        int vertices = 0;
        int corners = 0;
        int groups = 0;
        byte keyword = '\n';
        boolean inWord = false;
        for (byte b : bytes) {
            boolean gap = b == ' ' || b == '\t' || b == '\r';
            if (b == '\n') {
                keyword = '\n';
            } else if (keyword == '\n' && !gap) {
                keyword = b;
                vertices += b == 'v' ? 1 : 0;
                groups += b == 'g' || b == 'o' || b == 'u' || b == 'm' ? 1 : 0;
            } else if (!gap && !inWord) {
                corners += keyword == 'f' ? 1 : 0;
                groups += keyword == 'g' || keyword == 'm' ? 1 : 0;
            }
            inWord = b != '\n' && !gap;
        }
        if (vertices > 3 * Mesh.MAX_COUNT || corners > 3 * Mesh.MAX_COUNT) {
            throw sources.refuse("more than " + Mesh.MAX_COUNT + " vertices or triangles; simplify "
                    + "the mesh");
        }
        if (groups > MAX_GROUPS) {
            throw sources.refuse("more than " + MAX_GROUPS + " groups and materials");
        }
    }

    private Mesh read() throws AssetException {
        for (String library : obj.getMtlFileNames()) {
            readLibrary(library);
        }
        mesh.reserve(0, 0);
        for (int i = 0; i < obj.getNumFaces(); i++) {
            add(obj.getFace(i));
        }
        return mesh.finish(!materials.isEmpty());
    }

    private void readLibrary(String name) throws AssetException {
        try {
            byte[] bytes = sources.file(name, MAX_LIBRARY_BYTES);
            for (Mtl mtl : MtlReader.read(new ByteArrayInputStream(bytes))) {
                materials.put(mtl.getName(), material(mtl));
            }
        } catch (IOException | RuntimeException broken) {
            throw sources.refuse("material library " + name + " is not MTL: one of its lines has "
                    + "no number where one is expected");
        }
    }

    private Material material(Mtl mtl) throws AssetException {
        FloatTuple colour = mtl.getKd();
        Optional<Texture> texture = mtl.getMapKd() == null ? Optional.empty()
                : Optional.of(sources.image(mtl.getMapKd()));
        return new Material(colour == null ? Colour.WHITE : colour(colour),
                mtl.getPr() == null ? Material.DEFAULT.roughness() : mtl.getPr(),
                mtl.getPm() == null ? Material.DEFAULT.metallic() : mtl.getPm(), texture);
    }

    /** By custom, the colours of these files are sRGB. */
    private static Colour colour(FloatTuple rgb) {
        int rgba = 0xff;
        for (int i = 2; i >= 0; i--) {
            rgba = rgba << 8 | Math.round(255 * Math.clamp(rgb.get(i), 0f, 1f));
        }
        return new Colour(rgba);
    }

    private void add(ObjFace face) throws AssetException {
        followMaterial(face);
        mesh.reserve(0, face.getNumVertices() - 2L);
        int first = vertex(face, 0);
        int previous = vertex(face, 1);
        for (int corner = 2; corner < face.getNumVertices(); corner++) {
            int next = vertex(face, corner);
            mesh.triangle(first, previous, next, material);
            previous = next;
        }
    }

    /** The library names a material at the first face only that is in it. */
    private void followMaterial(ObjFace face) {
        @Nullable String name = obj.getActivatedMaterialGroupName(face);
        if (name != null) {
            material = materials.getOrDefault(name, Material.DEFAULT);
        }
    }

    private int vertex(ObjFace face, int at) throws AssetException {
        var corner = new Corner(
                index(face.getVertexIndex(at), obj.getNumVertices(), "vertex"),
                face.containsTexCoordIndices()
                        ? index(face.getTexCoordIndex(at), obj.getNumTexCoords(), "vt") : -1,
                face.containsNormalIndices()
                        ? index(face.getNormalIndex(at), obj.getNumNormals(), "vn") : -1);
        Integer known = vertices.get(corner);
        if (known != null) {
            return known;
        }
        mesh.reserve(1, 0);
        FloatTuple position = obj.getVertex(corner.position);
        int added = mesh.vertex(position.getX(), position.getY(), position.getZ());
        if (corner.coordinates >= 0) {
            FloatTuple uv = obj.getTexCoord(corner.coordinates);
            mesh.coordinates(uv.getX(), 1 - (uv.getDimensions() > 1 ? uv.getY() : 0));
        }
        if (corner.normal >= 0) {
            FloatTuple normal = obj.getNormal(corner.normal);
            mesh.normal(normal.getX(), normal.getY(), normal.getZ());
        }
        vertices.put(corner, added);
        return added;
    }

    private int index(int index, int count, String what) throws AssetException {
        if (index < 0 || index >= count) {
            throw sources.refuse("a face refers to " + what + " " + (index + 1L) + ", there are "
                    + count);
        }
        return index;
    }
}
