// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

/** A position [m] or a direction in the world; right-handed axes, +Y up. */
public record Point(double x, double y, double z) {

    Point plus(double factor, Point other) {
        return new Point(x + factor * other.x, y + factor * other.y, z + factor * other.z);
    }

    double dot(Point other) {
        return x * other.x + y * other.y + z * other.z;
    }

    Point cross(Point other) {
        return new Point(
                y * other.z - z * other.y, z * other.x - x * other.z, x * other.y - y * other.x);
    }

    Point normalized() {
        double length = Math.sqrt(dot(this));
        return new Point(x / length, y / length, z / length);
    }
}
