// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

/**
 * An affine transformation of a glTF node: rotation, scale, shear and translation.
 *
 * @param m (3 x 4) matrix stored by rows; the last column is the translation
 */
record Placement(double[] m) {

    static final Placement IDENTITY =
            new Placement(new double[] {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});

    /**
     * Returns the transformation of a matrix.
     *
     * @param columns (4 x 4) matrix stored by columns, the order of glTF
     */
    static Placement of(float[] columns) {
        double[] m = new double[12];
        for (int i = 0; i < 12; i++) {
            m[i] = columns[i % 4 * 4 + i / 4];
        }
        return new Placement(m);
    }

    /**
     * Returns a transformation that scales first, then rotates and then translates.
     *
     * @param rotation quaternion xyzw of any length
     */
    static Placement of(float[] scale, float[] rotation, float[] translation) {
        double x = rotation[0];
        double y = rotation[1];
        double z = rotation[2];
        double w = rotation[3];
        double s = 2 / (x * x + y * y + z * z + w * w);
        double a = scale[0];
        double b = scale[1];
        double c = scale[2];
        return new Placement(
                new double[] {
                    a * (1 - s * (y * y + z * z)),
                    b * s * (x * y - z * w),
                    c * s * (x * z + y * w),
                    translation[0],
                    a * s * (x * y + z * w),
                    b * (1 - s * (x * x + z * z)),
                    c * s * (y * z - x * w),
                    translation[1],
                    a * s * (x * z - y * w),
                    b * s * (y * z + x * w),
                    c * (1 - s * (x * x + y * y)),
                    translation[2]
                });
    }

    /**
     * Returns the transformation that applies {@code inner} first, and this transformation after
     * it.
     */
    Placement times(Placement inner) {
        double[] product = new double[12];
        for (int row = 0; row < 3; row++) {
            for (int column = 0; column < 4; column++) {
                double sum = column == 3 ? m[4 * row + 3] : 0;
                for (int k = 0; k < 3; k++) {
                    sum += m[4 * row + k] * inner.m[4 * k + column];
                }
                product[4 * row + column] = sum;
            }
        }
        return new Placement(product);
    }

    /** Returns the coordinate of the transformed point along an axis (0, 1, 2). */
    float point(int axis, float x, float y, float z) {
        return (float)
                (m[4 * axis] * x + m[4 * axis + 1] * y + m[4 * axis + 2] * z + m[4 * axis + 3]);
    }

    /**
     * Returns the transformation for normals, which is the matrix of cofactors. It keeps normals
     * perpendicular to the surface under any scale.
     */
    Placement forNormals() {
        double[] turned = new double[12];
        for (int row = 0; row < 3; row++) {
            for (int column = 0; column < 3; column++) {
                int r1 = 4 * ((row + 1) % 3);
                int r2 = 4 * ((row + 2) % 3);
                int c1 = (column + 1) % 3;
                int c2 = (column + 2) % 3;
                turned[4 * row + column] = m[r1 + c1] * m[r2 + c2] - m[r1 + c2] * m[r2 + c1];
            }
        }
        return new Placement(turned);
    }

    /**
     * Returns whether the transformation contains a reflection, which inverts the order of corners.
     */
    boolean mirrors() {
        Placement cofactors = forNormals();
        return m[0] * cofactors.m[0] + m[1] * cofactors.m[1] + m[2] * cofactors.m[2] < 0;
    }
}
