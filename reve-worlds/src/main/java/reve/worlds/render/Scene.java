package reve.worlds.render;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.TreeMap;
import reve.core.world.Mesh;
import reve.core.world.Shape;

/**
 * What one picture shows, as the columns of the scene stream. Filled by one thread, then rendered
 * as often as wanted. Coordinates are in metres, finite and at most 1e15.
 */
public final class Scene {

    private final ImageFormat image;
    private final Camera camera;
    private final Environment environment;
    private final Map<Integer, Instances> simple = new TreeMap<>();
    private final Map<Mesh, Instances> meshes = new LinkedHashMap<>();
    private final Map<Float, Segments> segments = new TreeMap<>();

    public Scene(ImageFormat image, Camera camera, Environment environment) {
        this.image = image;
        this.camera = camera;
        this.environment = environment;
    }

    public ImageFormat image() {
        return image;
    }

    public Camera camera() {
        return camera;
    }

    public Environment environment() {
        return environment;
    }

    /** Spheres, boxes or planes, to be added to. */
    public Instances instances(int shape) {
        if (shape != Shape.SPHERE && shape != Shape.BOX && shape != Shape.PLANE) {
            throw new IllegalArgumentException("shape code " + shape + ", expected sphere "
                    + Shape.SPHERE + ", box " + Shape.BOX + " or plane " + Shape.PLANE);
        }
        return simple.computeIfAbsent(shape, code -> new Instances());
    }

    /** Items that look like a mesh, to be added to. A renderer is sent every mesh but once. */
    public Instances instances(Mesh mesh) {
        return meshes.computeIfAbsent(mesh, key -> new Instances());
    }

    /** Lines, to be added to. @param widthPixels 0.25 to 64 */
    public Segments segments(float widthPixels) {
        return segments.computeIfAbsent(widthPixels, width -> new Segments());
    }

    /** @throws IllegalStateException if a row lacks a value */
    void requireComplete() {
        simple.values().forEach(Instances::count);
        meshes.values().forEach(Instances::count);
        segments.values().forEach(Segments::count);
    }

    Map<Integer, Instances> simple() {
        return Collections.unmodifiableMap(simple);
    }

    Map<Mesh, Instances> meshes() {
        return Collections.unmodifiableMap(meshes);
    }

    Map<Float, Segments> segments() {
        return Collections.unmodifiableMap(segments);
    }
}
