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
 * What one picture shows, as the columns of the scene stream. Filled by one thread, then rendered
 * as often as wanted. Coordinates are in metres, finite and at most 1e15.
 */
public final class Scene {

    private final ImageFormat image;
    private final Camera camera;
    private final Environment environment;
    private final Map<Look, Instances> instances = new LinkedHashMap<>();
    private final Map<Float, Segments> segments = new TreeMap<>();
    private final Triangles triangles = new Triangles();

    /**
     * What instances have in common.
     *
     * @param shape code of the shape
     * @param mesh for {@link Shape#MESH}
     * @param triangleCount of the mesh from {@code firstTriangle} on; 0: all
     */
    record Look(
            int shape,
            @Nullable Mesh mesh,
            Material material,
            int firstTriangle,
            int triangleCount) {}

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

    /** Spheres, boxes or planes of the default material, to be added to. */
    public Instances instances(int shape) {
        return instances(shape, Material.DEFAULT);
    }

    /** Items that look like a mesh in the default material, to be added to. */
    public Instances instances(Mesh mesh) {
        return instances(mesh, Material.DEFAULT);
    }

    /** Spheres, boxes or planes of one material, to be added to. */
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

    /** Items that look like a mesh in one material. A renderer is sent every mesh but once. */
    public Instances instances(Mesh mesh, Material material) {
        return of(new Look(Shape.MESH, mesh, material, 0, 0));
    }

    /** Items that look like a part of a mesh, in its material. */
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

    /** Triangles of no item, to be added to. */
    public Triangles triangles() {
        return triangles;
    }

    /** Lines, to be added to. @param widthPixels 0.25 to 64 */
    public Segments segments(float widthPixels) {
        return segments.computeIfAbsent(widthPixels, width -> new Segments());
    }

    /**
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
