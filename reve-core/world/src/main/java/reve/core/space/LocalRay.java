// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import static java.lang.Double.POSITIVE_INFINITY;

/**
 * A ray (half-line) in the axes of a shape, and its intersections with shapes at the origin of
 * these axes. A distance is that of the nearest point of the surface in front of the ray's origin
 * [m]. The surface counts from both sides. A ray that begins inside a shape therefore meets the
 * surface at the point where it leaves the shape. A distance is infinite if the ray meets no point.
 * Reusable; for one thread.
 */
public final class LocalRay {

    private double ox;
    private double oy;
    private double oz;
    private double dx;
    private double dy;
    private double dz;

    /** Distances at which the line enters and leaves a solid; empty if enter is above leave. */
    private double enter;

    private double leave;

    /**
     * Sets the ray, and converts it into the axes of a shape.
     *
     * @param origin (3) [m]
     * @param direction (3) of length 1
     * @param place location (3) [m] and orientation (4, unit quaternion xyzw) of the shape
     */
    public void set(double[] origin, double[] direction, double[] place) {
        setOrigin(origin, place);
        setDirection(direction, 0, place);
    }

    /**
     * Sets only the origin of the ray. A caller with many rays from one origin converts the origin
     * once, and then calls {@link #setDirection} for each ray.
     *
     * @param origin (3) [m]
     * @param place as for {@link #set}
     */
    public void setOrigin(double[] origin, double[] place) {
        double x = origin[0] - place[0];
        double y = origin[1] - place[1];
        double z = origin[2] - place[2];
        double ux = -place[3];
        double uy = -place[4];
        double uz = -place[5];
        double w = place[6];
        double cx = 2 * (uy * z - uz * y);
        double cy = 2 * (uz * x - ux * z);
        double cz = 2 * (ux * y - uy * x);
        ox = x + w * cx + (uy * cz - uz * cy);
        oy = y + w * cy + (uz * cx - ux * cz);
        oz = z + w * cz + (ux * cy - uy * cx);
    }

    /**
     * Sets only the direction of the ray.
     *
     * @param directions contains the direction (3) of length 1
     * @param at index of the direction's first component
     * @param place as for {@link #set}
     */
    public void setDirection(double[] directions, int at, double[] place) {
        double ux = -place[3];
        double uy = -place[4];
        double uz = -place[5];
        double w = place[6];
        double a = directions[at];
        double b = directions[at + 1];
        double c = directions[at + 2];
        double cx = 2 * (uy * c - uz * b);
        double cy = 2 * (uz * a - ux * c);
        double cz = 2 * (ux * b - uy * a);
        dx = a + w * cx + (uy * cz - uz * cy);
        dy = b + w * cy + (uz * cx - ux * cz);
        dz = c + w * cz + (ux * cy - uy * cx);
    }

    void copyTo(double[] origin, double[] direction) {
        origin[0] = ox;
        origin[1] = oy;
        origin[2] = oz;
        direction[0] = dx;
        direction[1] = dy;
        direction[2] = dz;
    }

    /** Returns the distance to a sphere. */
    public double toSphere(double radius) {
        crossSphere(0, radius);
        return nearest();
    }

    /** Returns the distance to an ellipsoid with these half extents. */
    public double toEllipsoid(double halfX, double halfY, double halfZ) {
        double x = ox / halfX; // in axes in which the ellipsoid is a ball of radius 1
        double y = oy / halfY;
        double z = oz / halfZ;
        double u = dx / halfX;
        double v = dy / halfY;
        double w = dz / halfZ;
        double square = u * u + v * v + w * w;
        double foot = -(x * u + y * v + z * w) / square;
        double px = x + foot * u;
        double py = y + foot * v;
        double pz = z + foot * w;
        chord(foot, (1 - (px * px + py * py + pz * pz)) / square);
        return nearest();
    }

    /** Returns the distance to a box with these half extents. */
    public double toBox(double halfX, double halfY, double halfZ) {
        enter = Double.NEGATIVE_INFINITY;
        leave = POSITIVE_INFINITY;
        clip(ox, dx, halfX);
        clip(oy, dy, halfY);
        clip(oz, dz, halfZ);
        return nearest();
    }

    /** Returns the distance to a rectangle in the plane of the x and z axes. */
    public double toPlane(double halfX, double halfZ) {
        double distance = -oy / dy;
        boolean meets =
                distance > 0
                        && Math.abs(ox + distance * dx) <= halfX
                        && Math.abs(oz + distance * dz) <= halfZ;
        return meets ? distance : POSITIVE_INFINITY; // a ray in the plane has the distance NaN
    }

    /** Returns the distance to a cylinder along the y axis. */
    public double toCylinder(double radius, double halfHeight) {
        crossCylinder(radius, halfHeight);
        return nearest();
    }

    /**
     * Returns the distance to a cylinder along the y axis with a hemisphere at both ends.
     *
     * @param halfHeight half of the height, with both ends
     */
    public double toCapsule(double radius, double halfHeight) {
        double middle = halfHeight - radius;
        crossCylinder(radius, middle);
        double first = enter <= leave ? enter : POSITIVE_INFINITY;
        double last = enter <= leave ? leave : Double.NEGATIVE_INFINITY;
        for (int end = -1; end <= 1; end += 2) {
            crossSphere(end * middle, radius);
            if (enter <= leave) {
                first = Math.min(first, enter);
                last = Math.max(last, leave);
            }
        }
        enter = first; // a capsule is convex, so the three parts of the line form one
        leave = last;
        return nearest();
    }

    /**
     * Returns the distance to a triangle.
     *
     * <p>Source: T. Möller, B. Trumbore, <i>Fast, minimum storage ray/triangle intersection</i>,
     * Journal of Graphics Tools 2 (1997) 21.
     *
     * @param corners coordinates of points, three each
     * @param a index of the first coordinate of the first corner; b and c are those of the other
     *     two corners
     */
    double toTriangle(float[] corners, int a, int b, int c) {
        double ux = (double) corners[b] - corners[a];
        double uy = (double) corners[b + 1] - corners[a + 1];
        double uz = (double) corners[b + 2] - corners[a + 2];
        double vx = (double) corners[c] - corners[a];
        double vy = (double) corners[c + 1] - corners[a + 1];
        double vz = (double) corners[c + 2] - corners[a + 2];
        double px = dy * vz - dz * vy;
        double py = dz * vx - dx * vz;
        double pz = dx * vy - dy * vx;
        double determinant = ux * px + uy * py + uz * pz;
        double tx = ox - corners[a];
        double ty = oy - corners[a + 1];
        double tz = oz - corners[a + 2];
        double u = (tx * px + ty * py + tz * pz) / determinant;
        double qx = ty * uz - tz * uy;
        double qy = tz * ux - tx * uz;
        double qz = tx * uy - ty * ux;
        double v = (dx * qx + dy * qy + dz * qz) / determinant;
        double distance = (vx * qx + vy * qy + vz * qz) / determinant;
        boolean meets = u >= 0 && v >= 0 && u + v <= 1 && distance > 0;
        return meets && distance < POSITIVE_INFINITY ? distance : POSITIVE_INFINITY;
    }

    private double nearest() {
        if (!(enter <= leave)) {
            return POSITIVE_INFINITY;
        }
        return enter > 0 ? enter : leave > 0 ? leave : POSITIVE_INFINITY;
    }

    /** Limits the part of the line to that between two planes, at -half and half. */
    private void clip(double origin, double direction, double half) {
        if (direction == 0) {
            if (Math.abs(origin) > half) {
                enter = POSITIVE_INFINITY;
            }
            return;
        }
        double one = (-half - origin) / direction;
        double other = (half - origin) / direction;
        enter = Math.max(enter, Math.min(one, other));
        leave = Math.min(leave, Math.max(one, other));
    }

    private void crossCylinder(double radius, double halfHeight) {
        double across = dx * dx + dz * dz;
        if (across == 0) {
            boolean inside = ox * ox + oz * oz <= radius * radius;
            enter = inside ? Double.NEGATIVE_INFINITY : POSITIVE_INFINITY;
            leave = POSITIVE_INFINITY;
        } else {
            double foot = -(ox * dx + oz * dz) / across;
            double x = ox + foot * dx;
            double z = oz + foot * dz;
            chord(foot, (radius * radius - (x * x + z * z)) / across);
        }
        clip(oy, dy, halfHeight);
    }

    private void crossSphere(double centreY, double radius) {
        double y = oy - centreY;
        double foot = -(ox * dx + y * dy + oz * dz);
        double px = ox + foot * dx;
        double py = y + foot * dy;
        double pz = oz + foot * dz;
        chord(foot, radius * radius - (px * px + py * py + pz * pz));
    }

    private void chord(double foot, double squaredHalf) {
        double half = Math.sqrt(squaredHalf); // NaN if the line misses the solid
        enter = foot - half;
        leave = foot + half;
    }
}
