// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.EnumSet;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;

/**
 * What an agent perceives through its body. A body with sensors perceives nothing but what one of
 * them senses.
 *
 * <p>A camera senses no items: its agent is sent pictures when it asks to look.
 *
 * @param name unique among the sensors of a body
 * @param touch true if it senses what the body's bounding box comes as close to as the range; else
 *     it looks from the body's origin along its own +Z axis, the front of a glTF model
 * @param range how far it reaches [m], infinite for everything
 * @param fieldOfView full angle of the cone in which it sees [rad], 2π for all round; of a camera
 *     the vertical angle of its picture, at most {@link #WIDEST_CAMERA}
 * @param lineOfSight true if what is behind the bounding box of another item is hidden
 * @param every it senses every that many frames; in between the agent keeps what it knows
 * @param symbols which symbols it perceives; empty for all
 * @param aspects what it perceives of an item beside its name
 * @param camera what its pictures are like, if it is a camera
 */
public record Sensor(
        String name,
        boolean touch,
        double range,
        double fieldOfView,
        boolean lineOfSight,
        int every,
        Optional<SortedSet<String>> symbols,
        Set<Aspect> aspects,
        Optional<Camera> camera) {

    public static final double ALL_ROUND = 2 * Math.PI;

    /** The gap at which boxes count as touching, unless a sensor says otherwise [m]. */
    public static final double TOUCH_RANGE = 0.01;

    /** Widest vertical angle of a picture [rad]. */
    public static final double WIDEST_CAMERA = Math.toRadians(170);

    /**
     * What a camera's pictures are like.
     *
     * @param width [px]
     * @param height [px]
     * @param layers what they show of each pixel, at least one
     */
    public record Camera(int width, int height, Set<Layer> layers) {
        /** Most pixels of a picture. */
        public static final int MAX_PIXELS = 1 << 16;

        /**
         * @throws IllegalArgumentException if the size is out of its bounds
         */
        public Camera {
            if (width < 1 || height < 1 || (long) width * height > MAX_PIXELS) {
                throw new IllegalArgumentException(
                        "camera: "
                                + width
                                + " x "
                                + height
                                + " pixels, expected 1 or more a side and at most "
                                + MAX_PIXELS
                                + " in all");
            }
            layers = EnumSet.copyOf(layers);
        }

        /** A fresh copy. */
        @Override
        public Set<Layer> layers() {
            return EnumSet.copyOf(layers);
        }
    }

    /** What a picture shows of each pixel. */
    public enum Layer {
        /** Red, green and blue. */
        COLOUR,
        /** How far away it is. */
        DEPTH,
        /** Which item it is. */
        ITEMS
    }

    /** A side of an item that can be perceived. */
    public enum Aspect {
        /** Location and orientation. */
        PHYSICAL,
        /** Symbols. */
        SEMANTIC,
        /** Actions. */
        ACCESS
    }

    /**
     * @throws IllegalArgumentException if range, field of view or every is out of its bounds
     */
    public Sensor {
        if (!(range > 0)) {
            throw new IllegalArgumentException("range: " + range + " m is not more than 0");
        }
        if (!(fieldOfView > 0 && fieldOfView <= ALL_ROUND)) {
            throw new IllegalArgumentException(
                    "fieldOfView: " + fieldOfView + " rad is not between 0 and 360 deg");
        }
        if (camera.isPresent() && fieldOfView > WIDEST_CAMERA) {
            throw new IllegalArgumentException(
                    "fieldOfView: a camera sees 170 deg at most, found "
                            + Math.toDegrees(fieldOfView)
                            + " deg");
        }
        if (every < 1) {
            throw new IllegalArgumentException("every: " + every + " frames, expected 1 or more");
        }
        symbols = symbols.map(TreeSet::new);
        aspects = aspects.isEmpty() ? Set.of() : Set.copyOf(EnumSet.copyOf(aspects));
    }

    /** Sees everything all round, as far as it reaches. */
    public static Sensor sight(String name, double range) {
        return new Sensor(
                name,
                false,
                range,
                ALL_ROUND,
                false,
                1,
                Optional.empty(),
                EnumSet.allOf(Aspect.class),
                Optional.empty());
    }

    /** Feels everything that the body touches. */
    public static Sensor touch(String name) {
        return new Sensor(
                name,
                true,
                TOUCH_RANGE,
                ALL_ROUND,
                false,
                1,
                Optional.empty(),
                EnumSet.allOf(Aspect.class),
                Optional.empty());
    }

    /** Takes pictures. @param fieldOfView vertical angle of them [rad] */
    public static Sensor camera(String name, double fieldOfView, Camera pictures) {
        return new Sensor(
                name,
                false,
                Double.POSITIVE_INFINITY,
                fieldOfView,
                false,
                1,
                Optional.empty(),
                Set.of(),
                Optional.of(pictures));
    }

    /** The same, as far as that [m]. */
    public Sensor withRange(double metres) {
        return new Sensor(
                name, touch, metres, fieldOfView, lineOfSight, every, symbols, aspects, camera);
    }

    /** The same with another full angle of its cone [rad]. */
    public Sensor withFieldOfView(double radians) {
        return new Sensor(
                name, touch, range, radians, lineOfSight, every, symbols, aspects, camera);
    }

    /** The same, from which other items hide what is behind them. */
    public Sensor withLineOfSight() {
        return new Sensor(name, touch, range, fieldOfView, true, every, symbols, aspects, camera);
    }

    /** The same, which senses every so many frames. */
    public Sensor withEvery(int frames) {
        return new Sensor(
                name, touch, range, fieldOfView, lineOfSight, frames, symbols, aspects, camera);
    }

    /** The same, which perceives these symbols only. */
    public Sensor withSymbols(Set<String> names) {
        return new Sensor(
                name,
                touch,
                range,
                fieldOfView,
                lineOfSight,
                every,
                Optional.of(new TreeSet<>(names)),
                aspects,
                camera);
    }

    /** The same, which perceives these aspects. */
    public Sensor withAspects(Set<Aspect> some) {
        return new Sensor(
                name, touch, range, fieldOfView, lineOfSight, every, symbols, some, camera);
    }

    /** True if it takes pictures, and senses no items. */
    public boolean isCamera() {
        return camera.isPresent();
    }

    /** True if it also senses what has no place, such as a spring. */
    public boolean isUnlimited() {
        return !isCamera()
                && !touch
                && range == Double.POSITIVE_INFINITY
                && fieldOfView == ALL_ROUND
                && !lineOfSight;
    }
}
