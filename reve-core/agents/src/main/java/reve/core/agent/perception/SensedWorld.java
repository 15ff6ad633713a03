// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.space.Box;
import reve.core.space.BoxIndex;
import reve.core.space.Found;
import reve.core.world.ColumnView;
import reve.core.world.ScalarType;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.TableView;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.Arrays;
import java.util.function.LongPredicate;
import java.util.stream.LongStream;

/**
 * The positions and boxes of all bodies in one frame, and the test whether a sensor reaches a body.
 * Contains copies of the columns in plain arrays, which are reused for the next frame. For one
 * thread.
 *
 * <p>A touch sensor senses the items whose bounding box is within its range. Cameras, instruments
 * and hearing sensors sense no items. Any other sensor tests ten points of an item: the point of
 * the bounding box that is nearest to the eye, the box's centre, and its eight corners. The sensor
 * senses the item if one of these points is in its range and in its field of view. The point must
 * also not be hidden if the sensor needs a line of sight. A point is hidden if it lies behind the
 * bounding box of a third item that has a shape and does not contain the eye.
 */
public final class SensedWorld {

    /** Value of {@link #moment} that is before the first move of any body. */
    static final long BEFORE_ALL = -1;

    /** Value that represents no row. */
    static final int NOTHING = -1;

    private static final int CORNERS = 8;

    /**
     * Fraction of a line of sight at each of its ends. A box that the line crosses only within this
     * part does not hide the point.
     */
    private static final double END = 1e-9;

    private int rows;
    private double[] position = {};
    private double[] orientation = {};
    private double[] low = {};
    private double[] high = {};
    private int[] shape = {};

    // Positions of the previous frame, with which {@link #follow} compares the present ones. The
    // next fields contain other values of that frame.
    private double[] positionBefore = {};
    private double[] orientationBefore = {};
    private double[] lowBefore = {};
    private double[] highBefore = {};

    /** Number of calls of {@link #follow}. */
    private long moment;

    /** Moment at which the place or box of the body in each row last changed. */
    private long[] movedIn = {};

    private long lastMoved;

    /** Index of the boxes, built when it is first needed after a load. */
    private final BoxIndex index = new BoxIndex();

    private boolean indexed;
    private long[] keys = {};

    // The eye of the current test. The next fields are the tested point and the line of sight.
    private final double[] eye = new double[3];
    private final double[] point = new double[3];
    private final double[] ahead = new double[3];
    private double view = Double.NaN;
    private double cosHalfView;
    private int looker;
    private int target;
    private final LongPredicate found = this::findHider;
    private Hiders hiders = new Hiders();
    private final Hiders ofAnybody = hiders;

    /** Loads all bodies of a frame. */
    public void load(TableView bodies) {
        reserve(bodies.rowCount());
        read(bodies.column("position"), position, 0, 3 * rows);
        read(bodies.column("orientation"), orientation, 0, 4 * rows);
        read(bodies.column("boundsMin"), low, 0, 3 * rows);
        read(bodies.column("boundsMax"), high, 0, 3 * rows);
        MemorySegment.copy(
                bodies.column("shape").segment(), ValueLayout.JAVA_INT, 0, shape, 0, rows);
    }

    /**
     * Loads all bodies of a frame, and compares them with those of the frame loaded before.
     *
     * @param rearranged true if rows may contain other bodies, or the number of rows has changed;
     *     all bodies then count as moved
     * @return an upper bound on the distance that any body, or any corner of its box, has moved
     *     [m]; NaN or infinite if there is none
     */
    double follow(TableView bodies, boolean rearranged) {
        positionBefore = keep(position, positionBefore);
        orientationBefore = keep(orientation, orientationBefore);
        lowBefore = keep(low, lowBefore);
        highBefore = keep(high, highBefore);
        load(bodies);
        moment++;
        if (rearranged) {
            Arrays.fill(movedIn, moment);
            lastMoved = moment;
            return Double.POSITIVE_INFINITY;
        }
        markMoved(orientation, orientationBefore, 4);
        return Math.sqrt(3)
                * Math.max(
                        markMoved(position, positionBefore, 3),
                        Math.max(markMoved(low, lowBefore, 3), markMoved(high, highBefore, 3)));
    }

    private static double[] keep(double[] numbers, double[] into) {
        double[] kept = into.length < numbers.length ? new double[numbers.length] : into;
        System.arraycopy(numbers, 0, kept, 0, numbers.length);
        return kept;
    }

    /**
     * Marks the rows whose numbers have changed.
     *
     * @return the largest absolute difference
     */
    private double markMoved(double[] now, double[] before, int components) {
        double most = 0;
        for (int i = 0; i < components * rows; i++) {
            if (now[i] != before[i]) {
                movedIn[i / components] = moment;
                lastMoved = moment;
                most = Math.max(most, Math.abs(now[i] - before[i]));
            }
        }
        return most;
    }

    /** Returns the current moment, which is the number of calls of {@link #follow}. */
    long moment() {
        return moment;
    }

    /** Returns whether any body has moved after a {@link #moment}. */
    boolean haveAnyMoved(long since) {
        return lastMoved > since;
    }

    /** Returns whether the place or box of a body has changed after a {@link #moment}. */
    boolean hasMoved(int row, long since) {
        return movedIn[row] > since;
    }

    private void reserve(int rowCount) {
        rows = rowCount;
        if (shape.length < rows) {
            int capacity = Math.max(rows, 2 * shape.length);
            position = new double[3 * capacity];
            orientation = new double[4 * capacity];
            low = new double[3 * capacity];
            high = new double[3 * capacity];
            shape = new int[capacity];
            movedIn = new long[capacity];
            keys = LongStream.range(0, capacity).toArray();
        }
        indexed = false;
    }

    private void buildIndex() {
        if (!indexed) {
            index.build(
                    MemorySegment.ofArray(keys),
                    MemorySegment.ofArray(low),
                    MemorySegment.ofArray(high),
                    rows);
            indexed = true;
        }
    }

    /** Loads only two bodies, which is sufficient for sensors without line of sight. */
    public void load(TableView bodies, int a, int b) {
        reserve(bodies.rowCount());
        readRows(bodies.column("position"), position, a, b);
        readRows(bodies.column("orientation"), orientation, a, b);
        readRows(bodies.column("boundsMin"), low, a, b);
        readRows(bodies.column("boundsMax"), high, a, b);
    }

    private static void readRows(ColumnView column, double[] into, int a, int b) {
        read(column, into, column.components() * a, column.components());
        read(column, into, column.components() * b, column.components());
    }

    /** Copies numbers of a real column, by their index in the column. */
    static void read(ColumnView column, double[] into, int first, int count) {
        if (column.type() == ScalarType.F64) {
            MemorySegment.copy(
                    column.segment(),
                    ValueLayout.JAVA_DOUBLE,
                    (long) Double.BYTES * first,
                    into,
                    first,
                    count);
            return;
        }
        for (int i = first; i < first + count; i++) {
            into[i] = column.getDouble(i / column.components(), i % column.components());
        }
    }

    /** Returns location (3) [m] and orientation (4) of the body in a row. */
    double[] place(int row) {
        double[] place = new double[7];
        System.arraycopy(position, 3 * row, place, 0, 3);
        System.arraycopy(orientation, 4 * row, place, 3, 4);
        return place;
    }

    /** Copies location (3) [m] and orientation (4) of the body in a row. */
    void copyPlace(int row, double[] into) {
        System.arraycopy(position, 3 * row, into, 0, 3);
        System.arraycopy(orientation, 4 * row, into, 3, 4);
    }

    /** Converts a vector from the axes of the world to those of the body in a row. */
    void turnBack(int row, double[] vector) {
        double ux = -orientation[4 * row];
        double uy = -orientation[4 * row + 1];
        double uz = -orientation[4 * row + 2];
        double w = orientation[4 * row + 3];
        double cx = 2 * (uy * vector[2] - uz * vector[1]);
        double cy = 2 * (uz * vector[0] - ux * vector[2]);
        double cz = 2 * (ux * vector[1] - uy * vector[0]);
        vector[0] += w * cx + (uy * cz - uz * cy);
        vector[1] += w * cy + (uz * cx - ux * cz);
        vector[2] += w * cz + (ux * cy - uy * cx);
    }

    /** Returns the index of the boxes of this frame. The keys are rows. */
    BoxIndex index() {
        buildIndex();
        return index;
    }

    /** Returns whether the body in a row has exactly this location and orientation. */
    boolean isAt(int row, double[] place) {
        for (int i = 0; i < 7; i++) {
            double now = i < 3 ? position[3 * row + i] : orientation[4 * row + i - 3];
            if (now != place[i]) {
                return false;
            }
        }
        return true;
    }

    /** Returns the shape of the body in a row as its code, see {@link Shape}. */
    int shape(int row) {
        return shape[row];
    }

    /** Copies the corners of the box of the body in a row [m]. */
    void copyBox(int row, double[] lows, double[] highs, int at) {
        System.arraycopy(low, 3 * row, lows, at, 3);
        System.arraycopy(high, 3 * row, highs, at, 3);
    }

    Box box(int row) {
        int at = 3 * row;
        return new Box(low[at], low[at + 1], low[at + 2], high[at], high[at + 1], high[at + 2]);
    }

    /**
     * Sets the box of a body's reach to the body's own box. The method {@link #extendReach} extends
     * this box.
     */
    void reach(int body, double[] lows, double[] highs, int at) {
        System.arraycopy(low, 3 * body, lows, at, 3);
        System.arraycopy(high, 3 * body, highs, at, 3);
    }

    /** Extends the box of a body's reach by that of a sensor with this range. */
    void extendReach(Sensor sensor, double range, int body, double[] lows, double[] highs, int at) {
        double[] from = sensor.touch() ? low : position;
        double[] to = sensor.touch() ? high : position;
        for (int axis = 0; axis < 3; axis++) {
            lows[at + axis] = Math.min(lows[at + axis], from[3 * body + axis] - range);
            highs[at + axis] = Math.max(highs[at + axis], to[3 * body + axis] + range);
        }
    }

    /** Finds the rows of all boxes within the range of a sensor of the body. */
    void find(int body, Sensor sensor, double range, Found found) {
        buildIndex();
        int at = 3 * body;
        if (sensor.touch()) {
            index.inBox(
                    new Box(
                            low[at] - range,
                            low[at + 1] - range,
                            low[at + 2] - range,
                            high[at] + range,
                            high[at + 1] + range,
                            high[at + 2] + range),
                    found);
        } else {
            index.inSphere(position[at], position[at + 1], position[at + 2], range, found);
        }
    }

    /** Returns whether a sensor of the body in one row senses the item in another. */
    public boolean senses(Sensor sensor, int body, int row) {
        return senses(sensor, body, row, ofAnybody);
    }

    /**
     * Returns whether a sensor of the body in one row senses the item in another row.
     *
     * @param known the bodies that last hid other bodies from this body; this method updates them
     */
    public boolean senses(Sensor sensor, int body, int row, Hiders known) {
        hiders = known;
        if (!sensor.sensesItems()) {
            return false;
        }
        return sensor.touch()
                ? gapSquared(body, row) <= sensor.range() * sensor.range()
                : sees(sensor, body, row);
    }

    private double gapSquared(int a, int b) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            double gap =
                    Math.max(
                            0,
                            Math.max(
                                    low[3 * a + axis] - high[3 * b + axis],
                                    low[3 * b + axis] - high[3 * a + axis]));
            sum += gap * gap;
        }
        return sum;
    }

    private boolean sees(Sensor sensor, int body, int row) {
        if (Double.isNaN(low[3 * row])) {
            return false; // created in this frame: its box is computed at the end of the frame
        }
        lookAhead(sensor, body);
        for (int axis = 0; axis < 3; axis++) {
            point[axis] =
                    Math.clamp(
                            position[3 * body + axis], low[3 * row + axis], high[3 * row + axis]);
        }
        double nearest = distance(body);
        if (nearest > sensor.range()) {
            return false;
        }
        if (isSeen(sensor, body, row, nearest)) {
            return true;
        }
        for (int axis = 0; axis < 3; axis++) {
            point[axis] = 0.5 * (low[3 * row + axis] + high[3 * row + axis]);
        }
        boolean seen = isSeen(sensor, body, row, distance(body));
        for (int corner = 0; corner < CORNERS && !seen; corner++) {
            for (int axis = 0; axis < 3; axis++) {
                point[axis] =
                        (corner >> axis & 1) == 0 ? low[3 * row + axis] : high[3 * row + axis];
            }
            seen = isSeen(sensor, body, row, distance(body));
        }
        return seen;
    }

    /**
     * Returns whether a sensor sees the point of the current test.
     *
     * @param distance distance of the point from the eye [m]
     */
    private boolean isSeen(Sensor sensor, int body, int row, double distance) {
        return distance <= sensor.range()
                && isInView(sensor, body, distance)
                && !(sensor.lineOfSight() && distance > 0 && isHidden(body, row));
    }

    private double distance(int body) {
        double x = point[0] - position[3 * body];
        double y = point[1] - position[3 * body + 1];
        double z = point[2] - position[3 * body + 2];
        return Math.sqrt(x * x + y * y + z * z);
    }

    private boolean isInView(Sensor sensor, int body, double distance) {
        if (sensor.fieldOfView() >= Sensor.ALL_ROUND) {
            return true;
        }
        double ahead =
                this.ahead[0] * (point[0] - position[3 * body])
                        + this.ahead[1] * (point[1] - position[3 * body + 1])
                        + this.ahead[2] * (point[2] - position[3 * body + 2]);
        return ahead >= distance * cosHalfView;
    }

    /**
     * Computes the direction in which the sensor looks. This is the body's +Z axis, the third
     * column of the body's rotation matrix.
     */
    private void lookAhead(Sensor sensor, int body) {
        double x = orientation[4 * body];
        double y = orientation[4 * body + 1];
        double z = orientation[4 * body + 2];
        double w = orientation[4 * body + 3];
        ahead[0] = 2 * (x * z + w * y);
        ahead[1] = 2 * (y * z - w * x);
        ahead[2] = 1 - 2 * (x * x + y * y);
        if (sensor.fieldOfView() != view) {
            view = sensor.fieldOfView();
            cosHalfView = Math.cos(0.5 * view);
        }
    }

    /**
     * Returns the number of boxes that the searches for lines of sight have examined so far, see
     * {@link BoxIndex#visited}.
     */
    public long visited() {
        return index.visited();
    }

    private boolean isHidden(int body, int row) {
        buildIndex();
        looker = body;
        target = row;
        for (int i = 0; i < hiders.count(); i++) {
            int known = hiders.get(i);
            if (known != NOTHING && known < rows && hides(known)) {
                hiders.toFront(i);
                return true;
            }
        }
        System.arraycopy(position, 3 * body, eye, 0, 3);
        return index.isOnWay(eye, point, END, found);
    }

    private boolean hides(int box) {
        return box != looker && box != target && shape[box] != Shape.NONE && isBetween(looker, box);
    }

    private boolean findHider(long box) {
        boolean hides = hides((int) box);
        if (hides) {
            hiders.add((int) box);
        }
        return hides;
    }

    /**
     * Returns whether a box hides a point. A box hides the point if the line from the eye to the
     * point crosses the box and the box does not contain the eye. Uses the slab method.
     */
    private boolean isBetween(int body, int box) {
        double enter = 0;
        double leave = 1;
        boolean holdsEye = true;
        for (int axis = 0; axis < 3; axis++) {
            double from = position[3 * body + axis];
            double way = point[axis] - from;
            double min = low[3 * box + axis];
            double max = high[3 * box + axis];
            boolean inside = from >= min && from <= max;
            holdsEye &= inside;
            if (way == 0) {
                if (!inside) {
                    return false;
                }
            } else {
                double a = (min - from) / way;
                double b = (max - from) / way;
                enter = Math.max(enter, Math.min(a, b));
                leave = Math.min(leave, Math.max(a, b));
            }
        }
        return !holdsEye && enter <= leave && enter < 1 - END && leave > END;
    }
}
