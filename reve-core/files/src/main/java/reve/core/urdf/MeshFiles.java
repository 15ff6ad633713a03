// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.mesh.AssetException;
import reve.core.mesh.Assets;
import reve.core.mesh.HeightGrid;
import reve.core.mesh.MassProperties;
import reve.core.mesh.WorldFolder;
import reve.core.world.Mesh;
import reve.core.world.Shape;

import java.io.IOException;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.TreeMap;

/**
 * The mesh files that a robot names. This class finds and reads them. It converts each one into an
 * OBJ file in metres whose bounding box has its centre at the origin.
 */
final class MeshFiles {
    private static final String PACKAGE = "package://";
    private static final long MAX_BYTES = 64L << 20;

    /** Number of folders above the robot's folder that are searched for a package. */
    private static final int LEVELS = 6;

    private final Path folder;
    private final Map<String, Path> packages;
    private final Map<String, Converted> converted = new TreeMap<>();
    private final Map<String, String> texts = new TreeMap<>();
    private final Map<RobotModel.Form.Terrain, String> heights = new HashMap<>();

    /**
     * A mesh that was converted.
     *
     * @param file name in the folder of the world
     * @param centre centre of the bounding box in the axes of the original file (3) [m]
     * @param size size of the bounding box (3) [m]
     */
    record Converted(String file, double[] centre, double[] size) {}

    /**
     * @param folder the folder of the robot's file
     * @param packages folders of packages by name
     */
    MeshFiles(Path folder, Map<String, Path> packages) {
        this.folder = folder.toAbsolutePath().normalize();
        this.packages = packages;
    }

    /** Returns the texts of the OBJ files and of the files of heights by their names. */
    Map<String, String> texts() {
        return texts;
    }

    /**
     * Reads and converts a mesh. Returns an earlier result if the same mesh was already converted.
     *
     * @param place position of the reference to the mesh, for messages
     * @throws RobotFileException with the reason if the mesh cannot be read
     */
    Converted convert(String place, RobotModel.Form.MeshFile mesh) throws RobotFileException {
        String key = mesh.name() + " " + Arrays.toString(mesh.scale());
        Converted before = converted.get(key);
        if (before != null) {
            return before;
        }
        Mesh read;
        try {
            read = read(mesh.name());
        } catch (IllegalArgumentException | IOException | AssetException unreadable) {
            throw new RobotFileException(
                    place + ": mesh " + mesh.name() + ": " + reason(unreadable));
        }
        Converted result = write(mesh, read);
        converted.put(key, result);
        return result;
    }

    /** Adds a text with the heights of a terrain, and returns the name of its file. */
    String heights(RobotModel.Form.Terrain terrain) {
        String known = heights.get(terrain);
        if (known != null) {
            return known;
        }
        var text = new StringBuilder();
        for (float[] row : terrain.rows()) {
            for (int i = 0; i < row.length; i++) {
                text.append(i == 0 ? "" : " ").append(row[i]);
            }
            text.append('\n');
        }
        String file = fileName(terrain.name(), ".txt");
        texts.put(file, text.toString());
        heights.put(terrain, file);
        return file;
    }

    /**
     * Returns the heights in a grey PNG image as numbers from 0 to 1.
     *
     * @param place position of the reference to the image, for messages
     * @throws RobotFileException with the reason if the image cannot be read
     */
    HeightGrid image(String place, String name) throws RobotFileException {
        try {
            if (!Assets.isImageOfHeights(name)) {
                throw new IllegalArgumentException(
                        "this format is not read; convert the file to a grey PNG image");
            }
            Place found = find(name);
            return new Assets(new WorldFolder(found.root)).heights(found.path);
        } catch (IllegalArgumentException | AssetException unreadable) {
            throw new RobotFileException(
                    place + ": height field " + name + ": " + unreadable.getMessage());
        }
    }

    /**
     * Returns the volume and the inertia of a mesh at a density of 1 kg/m^3, in the axes of the
     * original file.
     *
     * @param place position of the reference to the mesh, for messages
     * @throws RobotFileException with the reason if the mesh cannot be read or encloses no volume
     */
    MassProperties solid(String place, RobotModel.Form.MeshFile mesh) throws RobotFileException {
        try {
            Mesh read = read(mesh.name());
            double[] scale = mesh.scale();
            FloatBuffer from = read.vertices();
            float[] vertices = new float[from.limit()];
            for (int i = 0; i < vertices.length; i++) {
                vertices[i] = (float) (scale[i % 3] * from.get(i));
            }
            IntBuffer corners = read.triangles();
            int[] triangles = new int[corners.limit()];
            corners.get(0, triangles);
            if (scale[0] * scale[1] * scale[2] < 0) {
                for (int i = 0; i < triangles.length; i += 3) {
                    int second = triangles[i + 1];
                    triangles[i + 1] = triangles[i + 2];
                    triangles[i + 2] = second;
                }
            }
            return MassProperties.of(Shape.mesh(vertices, triangles), 1);
        } catch (IllegalArgumentException | IOException | AssetException unreadable) {
            throw new RobotFileException(
                    place + ": mesh " + mesh.name() + ": " + reason(unreadable));
        }
    }

    private static String reason(Exception unreadable) {
        String message = String.valueOf(unreadable.getMessage());
        return unreadable instanceof IOException
                ? "the system does not read it: " + message
                : message;
    }

    private Mesh read(String name) throws IOException, AssetException {
        String lower = name.toLowerCase(Locale.ROOT);
        boolean stl = lower.endsWith(".stl");
        if (!stl && !lower.matches(".*\\.(obj|glb|gltf|dae)")) {
            throw new IllegalArgumentException(
                    "this format is not read; convert the file to STL, OBJ, glTF or COLLADA");
        }
        Place place = find(name);
        WorldFolder root = new WorldFolder(place.root);
        if (!stl) {
            return new Assets(root).meshInAxesOfFile(place.path);
        }
        Path file = root.find(place.path);
        if (Files.size(file) > MAX_BYTES) {
            throw new IllegalArgumentException("the file is larger than 64 MiB");
        }
        return StlReader.read(Files.readAllBytes(file));
    }

    /** Returns the place of an existing file. */
    private Place find(String name) {
        List<String> searched = new ArrayList<>();
        for (Place place : places(name)) {
            if (Files.isRegularFile(place.root.resolve(place.path))) {
                return place;
            }
            searched.add(place.root.resolve(place.path).toString());
        }
        throw new IllegalArgumentException(
                searched.isEmpty()
                        ? "the path leads out of the folder of the robot; copy the file into it,"
                                + " or name its folder by --package NAME=FOLDER"
                        : "the file was not found; searched "
                                + String.join(", ", searched)
                                + (name.startsWith(PACKAGE)
                                        ? "; name the folder of the package by --package"
                                                + " NAME=FOLDER"
                                        : ""));
    }

    /** A path inside a folder from which files may be read. */
    private record Place(Path root, String path) {}

    private List<Place> places(String name) {
        List<Place> places = new ArrayList<>();
        if (name.startsWith(PACKAGE)) {
            String rest = name.substring(PACKAGE.length());
            int slash = rest.indexOf('/');
            String called = slash < 0 ? "" : rest.substring(0, slash);
            String path = rest.substring(slash + 1);
            if (packages.containsKey(called)) {
                addPlace(places, packages.get(called), path);
                return places;
            }
            Path up = folder;
            for (int level = 0; up != null && level < LEVELS; level++, up = up.getParent()) {
                if (called.equals(String.valueOf(up.getFileName()))) {
                    addPlace(places, up, path);
                }
                if (Files.isDirectory(up.resolve(called)) && !called.isEmpty()) {
                    addPlace(places, up.resolve(called), path);
                }
            }
            if (places.isEmpty() && !called.isEmpty()) {
                addPlace(places, folder.resolve(called), path);
            }
            return places;
        }
        addPlace(places, folder, name);
        // The search continues in the parent folder. A typical robot/urdf/robot.urdf names
        // ../meshes/part.stl.
        if (places.isEmpty() && folder.getParent() != null) {
            Path up = folder.getParent();
            Path file = folder.resolve(name).normalize();
            if (file.startsWith(up)) {
                addPlace(places, up, up.relativize(file).toString());
            }
        }
        return places;
    }

    private static void addPlace(List<Place> places, Path root, String path) {
        Path file = root.resolve(path).normalize();
        if (file.startsWith(root) && !Path.of(path).isAbsolute()) {
            places.add(new Place(root, root.relativize(file).toString()));
        }
    }

    private Converted write(RobotModel.Form.MeshFile mesh, Mesh read) {
        double[] scale = mesh.scale();
        double[] centre = new double[3];
        double[] size = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            centre[axis] = 0.5 * scale[axis] * (read.min(axis) + read.max(axis));
            size[axis] = Math.abs(scale[axis]) * (read.max(axis) - read.min(axis));
        }
        boolean mirrored = scale[0] * scale[1] * scale[2] < 0;
        StringBuilder obj = new StringBuilder();
        FloatBuffer vertices = read.vertices();
        for (int i = 0; i < vertices.limit(); i += 3) {
            obj.append('v');
            for (int axis = 0; axis < 3; axis++) {
                double value = scale[axis] * vertices.get(i + axis) - centre[axis];
                obj.append(' ').append((float) value);
            }
            obj.append('\n');
        }
        IntBuffer triangles = read.triangles();
        for (int i = 0; i < triangles.limit(); i += 3) {
            int second = triangles.get(i + (mirrored ? 2 : 1)) + 1;
            int third = triangles.get(i + (mirrored ? 1 : 2)) + 1;
            obj.append("f ").append(triangles.get(i) + 1).append(' ').append(second);
            obj.append(' ').append(third).append('\n');
        }
        Converted result = new Converted(fileName(mesh.name(), ".obj"), centre, size);
        texts.put(result.file(), obj.toString());
        return result;
    }

    private String fileName(String name, String ending) {
        String base =
                name.substring(name.lastIndexOf('/') + 1)
                        .replaceFirst("\\.[^.]*$", "")
                        .replaceAll("[^A-Za-z0-9_-]", "_");
        String first = "meshes/" + (base.isEmpty() ? "mesh" : base);
        String file = first + ending;
        for (int i = 2; texts.containsKey(file); i++) {
            file = first + "-" + i + ending;
        }
        return file;
    }
}
