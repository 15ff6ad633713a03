// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter.Numeral;
import reve.core.urdf.RobotModel.Form;
import reve.core.urdf.RobotModel.Geometry;
import reve.core.world.Pose;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Writer of the shapes of a robot as physical properties of items. */
final class ShapeWriter {
    /** Rotation of the axis of cylinders from +Y, as in world files, to +Z, as in robot files. */
    private static final Pose ALONG_Z = new Pose(0, 0, 0, Math.sqrt(0.5), 0, 0, Math.sqrt(0.5));

    private final MeshFiles meshes;
    private final List<String> notes;

    /**
     * A shape in the form of a world file.
     *
     * @param physical physical properties of the item, without its pose
     * @param pose pose of the item in the frame of the link
     * @param half half extents of the bounding box (3) [m]
     * @param isBall whether the shape has the same extent in all directions
     */
    record Written(Map<String, Object> physical, Pose pose, double[] half, boolean isBall) {}

    ShapeWriter(MeshFiles meshes, List<String> notes) {
        this.meshes = meshes;
        this.notes = notes;
    }

    /** Returns a shape. Adds a note and returns empty if its mesh cannot be read. */
    Optional<Written> write(Geometry geometry, Optional<String> colour) {
        Map<String, Object> physical = new LinkedHashMap<>();
        Pose pose = geometry.pose();
        double[] half;
        switch (geometry.form()) {
            case Form.Box box -> {
                physical.put("shape", "box");
                physical.put("size", Numerals.exactly(box.size()));
                half = new double[] {box.size()[0] / 2, box.size()[1] / 2, box.size()[2] / 2};
            }
            case Form.Ellipsoid round -> {
                physical.put("shape", "ellipsoid");
                physical.put("size", Numerals.exactly(round.size()));
                half = new double[] {round.size()[0] / 2, round.size()[1] / 2, round.size()[2] / 2};
            }
            case Form.Sphere sphere -> {
                physical.put("shape", "sphere");
                physical.put("radius", Numeral.of(sphere.radius()));
                half = new double[] {sphere.radius(), sphere.radius(), sphere.radius()};
            }
            case Form.Cylinder cylinder -> {
                physical.put("shape", "cylinder");
                physical.put("radius", Numeral.of(cylinder.radius()));
                physical.put("height", Numeral.of(cylinder.length()));
                pose = ALONG_Z.within(pose);
                half = new double[] {cylinder.radius(), cylinder.length() / 2, cylinder.radius()};
            }
            case Form.Capsule capsule -> {
                physical.put("shape", "capsule");
                physical.put("radius", Numeral.of(capsule.radius()));
                physical.put("height", Numeral.of(capsule.length()));
                pose = ALONG_Z.within(pose);
                half = new double[] {capsule.radius(), capsule.length() / 2, capsule.radius()};
            }
            case Form.Plane plane -> {
                double[] size = {plane.x(), plane.y()};
                physical.put("shape", "plane");
                physical.put("size", Numerals.exactly(size));
                pose = ALONG_Z.within(pose);
                half = new double[] {plane.x() / 2, 0, plane.y() / 2};
            }
            case Form.Terrain terrain -> {
                double[] size = {terrain.x(), terrain.y()};
                physical.put("shape", "terrain");
                physical.put("size", Numerals.exactly(size));
                physical.put("file", meshes.heights(terrain));
                pose = ALONG_Z.within(pose);
                half = new double[] {terrain.x() / 2, 0, terrain.y() / 2};
            }
            case Form.MeshFile mesh -> {
                MeshFiles.Converted converted;
                try {
                    converted = meshes.convert(geometry.place(), mesh);
                } catch (RobotFileException unreadable) {
                    notes.add(unreadable.getMessage() + "; the shape is left out");
                    return Optional.empty();
                }
                physical.put("shape", "mesh");
                physical.put("file", converted.file());
                double[] c = converted.centre();
                pose = new Pose(c[0], c[1], c[2], 0, 0, 0, 1).within(pose);
                half =
                        new double[] {
                            converted.size()[0] / 2,
                            converted.size()[1] / 2,
                            converted.size()[2] / 2
                        };
            }
        }
        colour.ifPresent(text -> physical.put("colour", text));
        return Optional.of(
                new Written(physical, pose, half, geometry.form() instanceof Form.Sphere));
    }
}
