// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.EnumSet;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;

/**
 * A sensor, through which an agent perceives with its body. A body with sensors perceives only the
 * items that at least one of its sensors senses.
 *
 * <p>A camera senses no items. Its agent receives pictures on request. A sensor with an instrument
 * senses no items either. Its agent receives measured numbers. A hearing sensor hears what agents
 * with a {@link Voice} say, and senses no items.
 *
 * @param name name, unique among the sensors of a body
 * @param touch true if the sensor senses items whose boxes are within the range of the body's box.
 *     Otherwise it looks from the body's origin along the body's own +Z axis, which is the front of
 *     a glTF model
 * @param range maximum distance [m], infinite for no limit
 * @param fieldOfView full angle of the cone that the sensor sees [rad], 2π for all directions; for
 *     a camera the vertical angle of its picture, {@link #NARROWEST_CAMERA} to {@link
 *     #WIDEST_CAMERA}
 * @param lineOfSight true if the bounding boxes of items hide the items behind them
 * @param every interval between perceptions [frames]; the agent keeps the last perception meanwhile
 * @param symbols names of the perceived symbols; empty for all
 * @param aspects the perceived aspects of an item, in addition to its name
 * @param camera settings of the pictures; empty if the sensor is not a camera
 * @param instrument settings of a sensor that measures numbers; empty for other sensors
 * @param hearing true if the sensor hears voices within its range, which is measured between the
 *     bodies' origins
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
        Optional<Camera> camera,
        Optional<Instrument> instrument,
        boolean hearing) {

    public static final double ALL_ROUND = 2 * Math.PI;

    /** Default range of a touch sensor [m]. Boxes with at most this gap count as touching. */
    public static final double TOUCH_RANGE = 0.01;

    /** Minimum vertical angle of a picture [rad]. */
    public static final double NARROWEST_CAMERA = Math.toRadians(0.1);

    /** Maximum vertical angle of a picture [rad]. */
    public static final double WIDEST_CAMERA = Math.toRadians(170);

    /**
     * Settings of a camera's pictures.
     *
     * @param width [px]
     * @param height [px]
     * @param layers the kinds of data of each pixel, at least one
     */
    public record Camera(int width, int height, Set<Layer> layers) {
        /** Maximum number of pixels of a picture. */
        public static final int MAX_PIXELS = 1 << 16;

        /**
         * Checks the settings.
         *
         * @throws IllegalArgumentException if the size is out of bounds
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

        /** Returns a copy of the set of layers. */
        @Override
        public Set<Layer> layers() {
            return EnumSet.copyOf(layers);
        }
    }

    /** A kind of data of each pixel. */
    public enum Layer {
        /** Colour of the pixel: red, green and blue. */
        COLOUR,
        /** Distance of the visible surface along the view axis [m]. */
        DEPTH,
        /** Index of the visible item. */
        ITEMS
    }

    /** An aspect of an item that can be perceived. */
    public enum Aspect {
        /** The physical aspect: location and orientation. */
        PHYSICAL,
        /** The semantic aspect: symbols. */
        SEMANTIC,
        /** The access aspect: actions. */
        ACCESS
    }

    /**
     * Checks the numbers.
     *
     * @throws IllegalArgumentException if {@code range}, {@code fieldOfView} or {@code every} is
     *     out of bounds
     */
    public Sensor {
        if (!(range > 0)) {
            throw new IllegalArgumentException("range: " + range + " m is not more than 0");
        }
        if (!(fieldOfView > 0 && fieldOfView <= ALL_ROUND)) {
            throw new IllegalArgumentException(
                    "fieldOfView: " + fieldOfView + " rad is not between 0 and 360 deg");
        }
        if (camera.isPresent() && (fieldOfView < NARROWEST_CAMERA || fieldOfView > WIDEST_CAMERA)) {
            throw new IllegalArgumentException(
                    "fieldOfView: a camera sees 0.1 to 170 deg, found "
                            + Math.toDegrees(fieldOfView)
                            + " deg");
        }
        if (hearing && (camera.isPresent() || instrument.isPresent())) {
            throw new IllegalArgumentException("hearing: a camera or an instrument does not hear");
        }
        if (every < 1) {
            throw new IllegalArgumentException("every: " + every + " frames, expected 1 or more");
        }
        symbols = symbols.map(TreeSet::new);
        aspects = aspects.isEmpty() ? Set.of() : Set.copyOf(EnumSet.copyOf(aspects));
    }

    /** Creates a sensor that does not hear. */
    public Sensor(
            String name,
            boolean touch,
            double range,
            double fieldOfView,
            boolean lineOfSight,
            int every,
            Optional<SortedSet<String>> symbols,
            Set<Aspect> aspects,
            Optional<Camera> camera,
            Optional<Instrument> instrument) {
        this(
                name,
                touch,
                range,
                fieldOfView,
                lineOfSight,
                every,
                symbols,
                aspects,
                camera,
                instrument,
                false);
    }

    /** Returns a sensor that sees in all directions, up to the range. */
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
                Optional.empty(),
                Optional.empty());
    }

    /**
     * Returns a sensor that senses all items whose boxes touch the body's box, within {@link
     * #TOUCH_RANGE}.
     */
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
                Optional.empty(),
                Optional.empty());
    }

    /**
     * Returns a camera.
     *
     * @param fieldOfView vertical angle of its pictures [rad]
     */
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
                Optional.of(pictures),
                Optional.empty());
    }

    /** Returns a sensor that measures with an instrument and senses no items. */
    public static Sensor measuring(String name, Instrument instrument) {
        return new Sensor(
                name,
                false,
                Double.POSITIVE_INFINITY,
                ALL_ROUND,
                false,
                1,
                Optional.empty(),
                Set.of(),
                Optional.empty(),
                Optional.of(instrument));
    }

    /**
     * Returns a sensor that hears voices and senses no items.
     *
     * @param range maximum distance [m], infinite for no limit
     */
    public static Sensor hearing(String name, double range) {
        return new Sensor(
                name,
                false,
                range,
                ALL_ROUND,
                false,
                1,
                Optional.empty(),
                Set.of(),
                Optional.empty(),
                Optional.empty(),
                true);
    }

    /** Returns a copy with another range [m]. */
    public Sensor withRange(double metres) {
        return new Sensor(
                name,
                touch,
                metres,
                fieldOfView,
                lineOfSight,
                every,
                symbols,
                aspects,
                camera,
                instrument,
                hearing);
    }

    /** Returns a copy with another full angle of its cone [rad]. */
    public Sensor withFieldOfView(double radians) {
        return new Sensor(
                name,
                touch,
                range,
                radians,
                lineOfSight,
                every,
                symbols,
                aspects,
                camera,
                instrument,
                hearing);
    }

    /** Returns a copy that does not see items behind other items. */
    public Sensor withLineOfSight() {
        return new Sensor(
                name,
                touch,
                range,
                fieldOfView,
                true,
                every,
                symbols,
                aspects,
                camera,
                instrument,
                hearing);
    }

    /** Returns a copy with another interval [frames]. */
    public Sensor withEvery(int frames) {
        return new Sensor(
                name,
                touch,
                range,
                fieldOfView,
                lineOfSight,
                frames,
                symbols,
                aspects,
                camera,
                instrument,
                hearing);
    }

    /** Returns a copy that perceives only these symbols. */
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
                camera,
                instrument,
                hearing);
    }

    /** Returns a copy that perceives these aspects. */
    public Sensor withAspects(Set<Aspect> newAspects) {
        return new Sensor(
                name,
                touch,
                range,
                fieldOfView,
                lineOfSight,
                every,
                symbols,
                newAspects,
                camera,
                instrument,
                hearing);
    }

    /** Returns whether the sensor is a camera, which senses no items but takes pictures. */
    public boolean isCamera() {
        return camera.isPresent();
    }

    /**
     * Returns whether the sensor senses items. Cameras, instruments and hearing sensors sense none.
     */
    public boolean sensesItems() {
        return camera.isEmpty() && instrument.isEmpty() && !hearing;
    }

    /**
     * Returns whether the sensor senses all items, including those without a place, such as
     * springs.
     */
    public boolean isUnlimited() {
        return sensesItems()
                && !touch
                && range == Double.POSITIVE_INFINITY
                && fieldOfView == ALL_ROUND
                && !lineOfSight;
    }
}
