// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import org.jspecify.annotations.Nullable;

import reve.core.file.CameraDescription;
import reve.core.file.NamedCamera;
import reve.core.world.ColumnView;
import reve.core.world.ItemId;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.Optional;

/**
 * A named camera that follows the items of a running world. The camera uses the item's last known
 * place if an item leaves the world. For one thread.
 */
public final class CameraMount {
    private static final Point DOWN_Z = new Point(0, 0, -1);

    private final NamedCamera camera;
    private final Tracked followed;
    private final Tracked lookedAt;

    /** The place of an item, or its last known place if the item has left the world. */
    private static final class Tracked {
        private final Optional<String> name;
        private @Nullable ItemId id;
        private Point place = new Point(0, 0, 0);
        private double[] turn = {0, 0, 0, 1};

        Tracked(Optional<String> name) {
            this.name = name;
        }

        void update(WorldSnapshot snapshot) {
            if (name.isEmpty()) {
                return;
            }
            TableSnapshot bodies = snapshot.table(WorldPrototype.BODY);
            int row = row(snapshot, bodies, name.get());
            if (row < 0) {
                if (id == null) {
                    throw new RenderException(
                            "the camera needs item "
                                    + name.get()
                                    + ", which is not in the world at "
                                    + snapshot.timeSeconds()
                                    + " s");
                }
                return;
            }
            id = bodies.idAt(row);
            ColumnView position = bodies.column("position");
            place =
                    new Point(
                            position.getDouble(row, 0),
                            position.getDouble(row, 1),
                            position.getDouble(row, 2));
            ColumnView orientation = bodies.column("orientation");
            for (int i = 0; i < turn.length; i++) {
                turn[i] = orientation.getDouble(row, i);
            }
        }

        /**
         * Returns the row of the item. The item is found by its name at first, and by its id
         * afterwards.
         */
        private int row(WorldSnapshot snapshot, TableSnapshot bodies, String wanted) {
            if (id != null) {
                return bodies.rowOf(id);
            }
            for (int row = 0; row < bodies.rowCount(); row++) {
                if (snapshot.symbols().get(bodies.idAt(row)).name().equals(wanted)) {
                    return row;
                }
            }
            return -1;
        }

        /** Returns a vector rotated by the item's orientation. */
        Point turned(Point v) {
            var axis = new Point(turn[0], turn[1], turn[2]);
            double w = turn[3];
            double length = axis.dot(axis) + w * w;
            if (!(length > 0)) {
                return v;
            }
            // The formula v + 2 q x (q x v + w v) rotates a vector v by a quaternion (q, w) of
            // length 1.
            Point inner = axis.cross(v).plus(w, v);
            return v.plus(2 / length, axis.cross(inner));
        }
    }

    /** Creates the mount of a camera. */
    public CameraMount(NamedCamera camera) {
        this.camera = camera;
        this.followed = new Tracked(camera.follow());
        this.lookedAt = new Tracked(camera.lookAt());
    }

    /**
     * Returns the viewpoint in a state of the world. States must be given in the order of time.
     *
     * @throws RenderException if an item of the camera has not yet been in the world
     */
    public Camera at(WorldSnapshot snapshot) {
        followed.update(snapshot);
        lookedAt.update(snapshot);
        CameraDescription view = camera.at(snapshot.timeSeconds());
        Point eye = placed(point(view.eye()));
        Point target = camera.lookAt().isPresent() ? lookedAt.place : placed(point(view.target()));
        Point up = camera.turning() ? followed.turned(point(view.up())) : point(view.up());
        return sighted(eye, target, up, view.verticalFovRadians());
    }

    private Point placed(Point given) {
        Point offset = camera.turning() ? followed.turned(given) : given;
        return offset.plus(1, followed.place);
    }

    /**
     * Returns a camera with a valid line of sight. Replaces a target that is too near to the eye,
     * and an up direction that is parallel to the line of sight.
     */
    private static Camera sighted(Point eye, Point target, Point up, double fov) {
        Point aim = target;
        double farthest = Math.max(largest(eye), largest(target));
        if (!(length(aim.plus(-1, eye)) > CameraDescription.NEAREST_TARGET * farthest)) {
            aim = eye.plus(Math.max(1, largest(eye)), DOWN_Z);
        }
        Point sight = aim.plus(-1, eye);
        double least = CameraDescription.SMALLEST_TILT * length(sight);
        Point across = up;
        if (!(length(sight.cross(up)) > least * length(up))) {
            across = length(sight.cross(DOWN_Z)) > least ? DOWN_Z : new Point(0, 1, 0);
        }
        return Camera.perspective(eye, aim, across, fov);
    }

    private static double length(Point v) {
        return Math.sqrt(v.dot(v));
    }

    private static double largest(Point v) {
        return Math.max(Math.abs(v.x()), Math.max(Math.abs(v.y()), Math.abs(v.z())));
    }

    private static Point point(double[] values) {
        return new Point(values[0], values[1], values[2]);
    }
}
