// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi rotations (G. H. Golub and C.
 * F. Van Loan, Matrix Computations, section 8.5). The same matrix gives the same bits on every
 * machine.
 */
final class SymmetricEigen {

    /** Maximum number of sweeps. The method converges quadratically, so few sweeps suffice. */
    private static final int MAX_SWEEPS = 40;

    private SymmetricEigen() {}

    /**
     * Diagonalises a matrix in place. The diagonal then contains the eigenvalues.
     *
     * @param a symmetric matrix (n x n, row by row)
     * @return orthogonal matrix (n x n, row by row) whose columns are the eigenvectors
     */
    static double[] diagonalise(double[] a, int n) {
        double[] vectors = new double[n * n];
        for (int i = 0; i < n; i++) {
            vectors[(n + 1) * i] = 1;
        }
        boolean rotated = true;
        for (int sweep = 0; sweep < MAX_SWEEPS && rotated; sweep++) {
            rotated = false;
            for (int p = 0; p < n; p++) {
                for (int q = p + 1; q < n; q++) {
                    rotated |= rotate(a, vectors, n, p, q);
                }
            }
        }
        return vectors;
    }

    /** Makes one element outside of the diagonal 0. Returns false if it is negligible already. */
    private static boolean rotate(double[] a, double[] vectors, int n, int p, int q) {
        double element = a[n * p + q];
        double first = a[(n + 1) * p];
        double second = a[(n + 1) * q];
        if (first + element == first && second + element == second) {
            a[n * p + q] = 0;
            a[n * q + p] = 0;
            return false;
        }
        double theta = (second - first) / (2 * element);
        double tangent = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
        double cosine = 1 / Math.sqrt(tangent * tangent + 1);
        double sine = tangent * cosine;
        for (int k = 0; k < n; k++) {
            double kp = a[n * k + p];
            double kq = a[n * k + q];
            a[n * k + p] = cosine * kp - sine * kq;
            a[n * k + q] = sine * kp + cosine * kq;
        }
        for (int k = 0; k < n; k++) {
            double pk = a[n * p + k];
            double qk = a[n * q + k];
            a[n * p + k] = cosine * pk - sine * qk;
            a[n * q + k] = sine * pk + cosine * qk;
        }
        a[n * p + q] = 0;
        a[n * q + p] = 0;
        for (int k = 0; k < n; k++) {
            double kp = vectors[n * k + p];
            double kq = vectors[n * k + q];
            vectors[n * k + p] = cosine * kp - sine * kq;
            vectors[n * k + q] = sine * kp + cosine * kq;
        }
        return true;
    }
}
