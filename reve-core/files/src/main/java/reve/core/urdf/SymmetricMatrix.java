// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.world.Pose;

/**
 * A symmetric 3 x 3 matrix, which represents the inertia about three axes.
 *
 * @param values xx yy zz yz zx xy
 */
record SymmetricMatrix(double[] values) {
    private static final int MAX_SWEEPS = 50;

    /** Off-diagonal values below this fraction of the largest value count as 0. */
    private static final double SMALL = 1e-12;

    /**
     * The principal values and axes of a matrix.
     *
     * @param moments principal values (3)
     * @param axes rotation from the principal axes to the axes of the matrix, a unit quaternion
     *     xyzw
     */
    record Principal(double[] moments, double[] axes) {}

    SymmetricMatrix plus(SymmetricMatrix other) {
        double[] sum = values.clone();
        for (int i = 0; i < sum.length; i++) {
            sum[i] += other.values[i];
        }
        return new SymmetricMatrix(sum);
    }

    /**
     * Returns the inertia of a point mass about the origin.
     *
     * @param mass [kg]
     * @param at position of the point (3) [m]
     */
    static SymmetricMatrix ofPoint(double mass, double[] at) {
        double x = at[0];
        double y = at[1];
        double z = at[2];
        return new SymmetricMatrix(
                new double[] {
                    mass * (y * y + z * z),
                    mass * (z * z + x * x),
                    mass * (x * x + y * y),
                    -mass * y * z,
                    -mass * z * x,
                    -mass * x * y
                });
    }

    /**
     * Converts this matrix to other axes. The rotation of {@code turn} turns those axes into the
     * present axes of the matrix.
     */
    SymmetricMatrix turned(Pose turn) {
        double[][] r = rotation(turn.orientation());
        double[][] m = rows();
        double[][] out = new double[3][3];
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                for (int k = 0; k < 3; k++) {
                    for (int l = 0; l < 3; l++) {
                        out[i][j] += r[i][k] * m[k][l] * r[j][l];
                    }
                }
            }
        }
        return new SymmetricMatrix(
                new double[] {out[0][0], out[1][1], out[2][2], out[1][2], out[2][0], out[0][1]});
    }

    /**
     * Returns the principal values, by Jacobi rotations (G. H. Golub, C. F. Van Loan, Matrix
     * Computations, section 8.5). Each principal axis is as close as possible to the axis of the
     * matrix with the same number. A diagonal matrix is therefore not rotated.
     */
    Principal principal() {
        double[][] m = rows();
        double[][] v = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        double largest = 0;
        for (double value : values) {
            largest = Math.max(largest, Math.abs(value));
        }
        for (int sweep = 0; sweep < MAX_SWEEPS && offDiagonal(m) > SMALL * largest; sweep++) {
            for (int p = 0; p < 2; p++) {
                for (int q = p + 1; q < 3; q++) {
                    rotate(m, v, p, q);
                }
            }
        }
        return arranged(m, v);
    }

    private static double offDiagonal(double[][] m) {
        return Math.max(Math.abs(m[0][1]), Math.max(Math.abs(m[0][2]), Math.abs(m[1][2])));
    }

    /** Rotates the matrix so that the value in row p and column q becomes 0. */
    private static void rotate(double[][] m, double[][] v, int p, int q) {
        if (m[p][q] == 0) {
            return;
        }
        double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        double t = Math.copySign(1, theta) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
        double c = 1 / Math.sqrt(t * t + 1);
        double s = t * c;
        for (int k = 0; k < 3; k++) {
            double first = m[k][p];
            double second = m[k][q];
            m[k][p] = c * first - s * second;
            m[k][q] = s * first + c * second;
        }
        for (int k = 0; k < 3; k++) {
            double first = m[p][k];
            double second = m[q][k];
            m[p][k] = c * first - s * second;
            m[q][k] = s * first + c * second;
            first = v[k][p];
            second = v[k][q];
            v[k][p] = c * first - s * second;
            v[k][q] = s * first + c * second;
        }
    }

    /** Orders the axes, which are the columns of v, and makes them right-handed. */
    private static Principal arranged(double[][] m, double[][] v) {
        int[][] orders = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
        int[] best = orders[0];
        double most = -1;
        for (int[] order : orders) {
            double likeness = 0;
            for (int axis = 0; axis < 3; axis++) {
                likeness += Math.abs(v[axis][order[axis]]);
            }
            if (likeness > most + SMALL) {
                most = likeness;
                best = order;
            }
        }
        double[] moments = new double[3];
        double[][] r = new double[3][3];
        for (int axis = 0; axis < 3; axis++) {
            int from = best[axis];
            moments[axis] = m[from][from];
            double sign = v[axis][from] < 0 ? -1 : 1;
            for (int k = 0; k < 3; k++) {
                r[k][axis] = sign * v[k][from];
            }
        }
        double determinant =
                r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1])
                        - r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0])
                        + r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
        if (determinant < 0) {
            for (int k = 0; k < 3; k++) {
                r[k][2] = -r[k][2];
            }
        }
        return new Principal(moments, quaternion(r));
    }

    private double[][] rows() {
        double[] a = values;
        return new double[][] {{a[0], a[5], a[4]}, {a[5], a[1], a[3]}, {a[4], a[3], a[2]}};
    }

    private static double[][] rotation(double[] q) {
        double x = q[0];
        double y = q[1];
        double z = q[2];
        double w = q[3];
        return new double[][] {
            {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}
        };
    }

    /**
     * Returns the unit quaternion xyzw of a rotation matrix. Computes its largest part first, for
     * precision.
     */
    static double[] quaternion(double[][] r) {
        double trace = r[0][0] + r[1][1] + r[2][2];
        double[] q;
        if (trace > 0) {
            double s = 2 * Math.sqrt(1 + trace);
            q =
                    new double[] {
                        (r[2][1] - r[1][2]) / s,
                        (r[0][2] - r[2][0]) / s,
                        (r[1][0] - r[0][1]) / s,
                        s / 4
                    };
        } else {
            int i = r[1][1] > r[0][0] ? 1 : 0;
            i = r[2][2] > r[i][i] ? 2 : i;
            int j = (i + 1) % 3;
            int k = (i + 2) % 3;
            double s = 2 * Math.sqrt(1 + r[i][i] - r[j][j] - r[k][k]);
            q = new double[4];
            q[i] = s / 4;
            q[j] = (r[j][i] + r[i][j]) / s;
            q[k] = (r[k][i] + r[i][k]) / s;
            q[3] = (r[k][j] - r[j][k]) / s;
        }
        return Pose.of(new double[3], q).orientation();
    }
}
