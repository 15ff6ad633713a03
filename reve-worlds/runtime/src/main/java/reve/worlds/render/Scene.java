// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import org.jspecify.annotations.Nullable;

import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Shape;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.TreeMap;

/**
 * The content of one picture, as columns in the form that the renderer reads. One thread fills the
 * scene; afterwards it may be rendered any number of times. Coordinates are in metres, finite and
 * at most 1e15.
 */
public final class Scene {

    private final ImageFormat image;
    private final Camera camera;
    private final Environment environment;
    private final Map<Look, Instances> instances = new LinkedHashMap<>();
    private final Map<Float, Segments> segments = new TreeMap<>();
    private final Triangles triangles = new Triangles();

    /**
     * The shape and the material that instances share.
     *
     * @param shape code of the shape
     * @param mesh the mesh, only for {@link Shape#MESH}
     * @param triangleCount triangles of the mesh from {@code firstTriangle} on; 0 for all
     */
    record Look(
            int shape,
            @Nullable Mesh mesh,
            Material material,
            int firstTriangle,
            int triangleCount) {}

    /** Creates an empty scene. */
    public Scene(ImageFormat image, Camera camera, Environment environment) {
        this.image = image;
        this.camera = camera;
        this.environment = environment;
    }

    /** Returns the picture's size and quality. */
    public ImageFormat image() {
        return image;
    }

    /** Returns the viewpoint. */
    public Camera camera() {
        return camera;
    }

    /** Returns the light and the background. */
    public Environment environment() {
        return environment;
    }

    /** Returns the spheres, boxes or planes of the default material; the caller adds rows. */
    public Instances instances(int shape) {
        return instances(shape, Material.DEFAULT);
    }

    /** Returns the instances of a mesh in the default material; the caller adds rows. */
    public Instances instances(Mesh mesh) {
        return instances(mesh, Material.DEFAULT);
    }

    /** Returns the spheres, boxes or planes of one material; the caller adds rows. */
    public Instances instances(int shape, Material material) {
        if (shape != Shape.SPHERE && shape != Shape.BOX && shape != Shape.PLANE) {
            throw new IllegalArgumentException(
                    "shape code "
                            + shape
                            + ", expected sphere "
                            + Shape.SPHERE
                            + ", box "
                            + Shape.BOX
                            + " or plane "
                            + Shape.PLANE);
        }
        return of(new Look(shape, null, material, 0, 0));
    }

    /**
     * Returns the instances of a mesh in one material; the caller adds rows. Each mesh is sent to
     * the renderer once.
     */
    public Instances instances(Mesh mesh, Material material) {
        return of(new Look(Shape.MESH, mesh, material, 0, 0));
    }

    /** Returns the instances of a part of a mesh in the part's material; the caller adds rows. */
    public Instances instances(Mesh mesh, Mesh.Part part) {
        return of(
                new Look(
                        Shape.MESH,
                        mesh,
                        part.material(),
                        part.firstTriangle(),
                        part.triangleCount()));
    }

    private Instances of(Look look) {
        return instances.computeIfAbsent(look, key -> new Instances());
    }

    /** Returns the triangles that belong to no mesh. The caller adds rows. */
    public Triangles triangles() {
        return triangles;
    }

    /**
     * Returns the lines of one width; the caller adds rows.
     *
     * @param widthPixels 0.25 to 64 [px]
     */
    public Segments segments(float widthPixels) {
        return segments.computeIfAbsent(widthPixels, width -> new Segments());
    }

    /**
     * Refuses an incomplete scene.
     *
     * @throws IllegalStateException if a row lacks a value
     */
    void requireComplete() {
        instances.values().forEach(Instances::count);
        segments.values().forEach(Segments::count);
        triangles.count();
    }

    Map<Look, Instances> instances() {
        return Collections.unmodifiableMap(instances);
    }

    Map<Float, Segments> segments() {
        return Collections.unmodifiableMap(segments);
    }
}
