// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.file.CameraDescription;

import java.util.Random;

class CameraTest {

    /**
     * Returns the largest distance of a corner of the box from the middle of the picture, as a
     * share of half the picture's width or height.
     */
    private static double fill(Camera camera, Bounds bounds, double aspect) {
        Point forward = camera.target().plus(-1, camera.eye()).normalized();
        Point right = forward.cross(camera.up()).normalized();
        Point up = right.cross(forward);
        double slope = Math.tan(camera.extent() / 2);
        double fill = 0;
        for (int i = 0; i < 8; i++) {
            Point corner = bounds.corner(i).plus(-1, camera.eye());
            double depth = corner.dot(forward);
            assertThat(depth).isPositive();
            fill = Math.max(fill, Math.abs(corner.dot(up)) / (depth * slope));
            fill = Math.max(fill, Math.abs(corner.dot(right)) / (depth * slope * aspect));
        }
        return fill;
    }

    @Test
    void fitShowsTheWholeBoxWellFilledForAnyBoxAndAspect() {
        long seed = 4711;
        var random = new Random(seed);
        for (int i = 0; i < 1000; i++) {
            var low = new Point(random.nextGaussian() * 100, random.nextGaussian(), 0);
            double scale = Math.pow(10, random.nextInt(-3, 6));
            var bounds =
                    new Bounds(
                            low,
                            low.plus(
                                    scale,
                                    new Point(
                                            random.nextDouble(),
                                            random.nextDouble(),
                                            random.nextDouble())));
            double aspect = 0.3 + 3 * random.nextDouble();
            assertThat(fill(Camera.fit(bounds, aspect), bounds, aspect))
                    .as("seed %d, case %d: %s, aspect %f", seed, i, bounds, aspect)
                    .isCloseTo(0.82, within(1e-6));
        }
    }

    @Test
    void fitLooksDownFromTheFrontRightWithYUp() {
        Camera camera = Camera.fit(new Bounds(new Point(-1, -1, -1), new Point(1, 1, 1)), 1.5);
        assertThat(camera.target()).isEqualTo(new Point(0, 0, 0));
        assertThat(camera.up()).isEqualTo(new Point(0, 1, 0));
        assertThat(camera.eye().x()).isPositive().isLessThan(camera.eye().z());
        assertThat(camera.eye().y()).isPositive().isLessThan(camera.eye().z());
        assertThat(camera.orthographic()).isFalse();
    }

    @Test
    void fitShowsAPointAsIfItWereOneMetreWide() {
        var point = new Point(7, 8, 9);
        Camera camera = Camera.fit(new Bounds(point, point), 2);
        double distance = Math.sqrt(camera.eye().plus(-1, point).dot(camera.eye().plus(-1, point)));
        assertThat(Math.tan(camera.extent() / 2) * distance * 0.82).isCloseTo(0.5, within(1e-9));
    }

    /**
     * Returns the place of a point in the picture, to the right of its middle and above it [px].
     */
    private static double[] project(Camera camera, Point point, int height) {
        Point forward = camera.target().plus(-1, camera.eye()).normalized();
        Point right = forward.cross(camera.up()).normalized();
        Point up = right.cross(forward);
        Point seen = point.plus(-1, camera.eye());
        double halfHeight =
                camera.orthographic()
                        ? camera.extent() / 2
                        : seen.dot(forward) * Math.tan(camera.extent() / 2);
        double scale = height / 2.0 / halfHeight;
        return new double[] {scale * seen.dot(right), scale * seen.dot(up)};
    }

    @Test
    void twoPointsOneMetreApartAtTheTargetAreAsFarApartAsTheScaleSays() {
        long seed = 4712;
        var random = new Random(seed);
        for (int i = 0; i < 1000; i++) {
            var target = new Point(random.nextGaussian(), random.nextGaussian(), 3);
            var aside = new Point(random.nextGaussian(), random.nextGaussian(), 0.1);
            Point eye = target.plus(Math.pow(10, random.nextInt(0, 4)), aside);
            var up = new Point(0.1, 1, 0.2);
            Camera camera =
                    i % 2 == 0
                            ? Camera.perspective(eye, target, up, 0.1 + 2 * random.nextDouble())
                            : Camera.orthographic(eye, target, up, 1 + 9 * random.nextDouble());
            Point along =
                    aside.cross(new Point(random.nextGaussian(), 1, random.nextGaussian()))
                            .normalized();
            double[] one = project(camera, target.plus(0.5, along), 640);
            double[] other = project(camera, target.plus(-0.5, along), 640);
            double pixels = Math.hypot(one[0] - other[0], one[1] - other[1]);
            assertThat(pixels * camera.metresPerPixel(640))
                    .as("seed %d, case %d: %s", seed, i, camera)
                    .isCloseTo(1, within(1e-9));
        }
    }

    @Test
    void boundsAreNotInsideOut() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new Bounds(new Point(0, 1, 0), new Point(1, 0, 1)));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new Bounds(new Point(0, Double.NaN, 0), new Point(1, 0, 1)));
        var flat = new Bounds(new Point(0, 0, 0), new Point(1, 0, 3));
        assertThatIllegalArgumentException().isThrownBy(() -> Camera.fit(flat, 0));
        assertThat(flat.longestSide()).isEqualTo(3);
    }

    @Test
    void theCameraOfAWorldFileIsTakenAsItIs() {
        Camera camera =
                Camera.of(
                        new CameraDescription(
                                new double[] {1, 2, 3},
                                new double[] {4, 5, 6},
                                new double[] {0, 0, 1},
                                0.7));
        assertThat(camera)
                .isEqualTo(
                        Camera.perspective(
                                new Point(1, 2, 3), new Point(4, 5, 6), new Point(0, 0, 1), 0.7));
    }

    @Test
    void picturesHaveALimitedSize() {
        assertThatIllegalArgumentException().isThrownBy(() -> ImageFormat.of(0, 10));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ImageFormat.of(8192, 8192))
                .withMessageContaining("16777216");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new ImageFormat(10, 10, 17, true))
                .withMessageContaining("17 samples");
    }
}
