// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.Instrument;

/**
 * The directions of a lidar's rays, and a search for the rays that may meet a ball. All rays have
 * the same origin, so the search needs only the directions in which the ball appears: an interval
 * of the rows, and one or two intervals of the columns. For one thread.
 *
 * <p>The search computes with sines and with the <i>turn</i> of a direction instead of angles, and
 * finds rows and columns in tables. A turn increases with the angle, and its computation needs only
 * one division.
 */
final class RayGrid {

    /**
     * Fraction of a ball's distance that the search adds to the ball's radius, for rounding errors.
     */
    private static final double WIDER = 1e-5;

    /** Turn of the directions towards -Z; the turns of all directions are from -BACK to BACK. */
    private static final double BACK = 2;

    private final int columns;
    private final double[] directions;
    private final Ascending rows;
    private final Ascending turns;

    // The result of the last search.
    private int firstRow;
    private int lastRow;
    private final int[] firstColumn = new int[2];
    private final int[] lastColumn = new int[2];
    private int parts;
    private double foundRadius;

    RayGrid(Instrument.Lidar lidar) {
        columns = lidar.columns();
        directions = new double[3 * lidar.rays()];
        double[] sines = new double[lidar.rows()];
        double[] turnOf = new double[columns];
        for (int row = 0; row < lidar.rows(); row++) {
            sines[row] = StrictMath.sin(lidar.upwards(row));
        }
        for (int column = 0; column < columns; column++) {
            double side = lidar.sideways(column);
            turnOf[column] = turn(StrictMath.sin(side), StrictMath.cos(side));
        }
        for (int i = 0; i < lidar.rays(); i++) {
            double side = lidar.sideways(i % columns);
            double up = lidar.upwards(i / columns);
            directions[3 * i] = StrictMath.sin(side) * StrictMath.cos(up);
            directions[3 * i + 1] = StrictMath.sin(up);
            directions[3 * i + 2] = StrictMath.cos(side) * StrictMath.cos(up);
        }
        rows = new Ascending(sines);
        turns = new Ascending(turnOf);
    }

    /**
     * Returns the directions in the axes of the lidar's body, (rays x 3), row by row. The rows go
     * from below to above, and each row goes from -X to +X.
     */
    double[] directions() {
        return directions;
    }

    /**
     * Finds the rays that may meet a ball: all that meet it, and some that pass it closely.
     *
     * @param x location of the ball's centre in the axes of the lidar [m]
     * @param radius [m]
     * @return false if no ray meets the ball
     */
    boolean find(double x, double y, double z, double radius) {
        double level = x * x + z * z;
        double square = level + y * y;
        double distance = Math.sqrt(square);
        double r = radius + WIDER * (radius + distance);
        foundRadius = r;
        if (!(distance > r)) { // also if a number is NaN or infinite
            findAll();
            return true;
        }
        double sine = r / distance;
        double cosine = Math.sqrt(1 - sine * sine);
        double height = Math.sqrt(level);
        double up = y / distance * cosine;
        double half = height / distance * sine;
        if (r >= height) { // the ball is above or below the lidar
            parts = 1;
            firstColumn[0] = 0;
            lastColumn[0] = columns - 1;
            return findRows(y > 0 ? up - half : -1, y > 0 ? 1 : up + half);
        }
        if (!findRows(up - half, up + half)) {
            return false;
        }
        double aside = r / height;
        double ahead = Math.sqrt(1 - aside * aside);
        double sin = x / height;
        double cos = z / height;
        double from = turn(sin * ahead - cos * aside, cos * ahead + sin * aside);
        double to = turn(sin * ahead + cos * aside, cos * ahead - sin * aside);
        parts = 0;
        if (from <= to) {
            findColumns(from, to);
        } else { // the ball is behind the lidar
            findColumns(from, BACK);
            findColumns(-BACK, to);
        }
        return parts > 0;
    }

    private void findAll() {
        firstRow = 0;
        lastRow = directions.length / 3 / columns - 1;
        parts = 1;
        firstColumn[0] = 0;
        lastColumn[0] = columns - 1;
    }

    private boolean findRows(double from, double to) {
        firstRow = rows.first(from);
        lastRow = rows.last(to);
        return firstRow <= lastRow;
    }

    private void findColumns(double from, double to) {
        int first = turns.first(from);
        int last = turns.last(to);
        if (first <= last) {
            firstColumn[parts] = first;
            lastColumn[parts] = last;
            parts++;
        }
    }

    /** Returns the radius of the ball of the last search, extended for rounding errors [m]. */
    double foundRadius() {
        return foundRadius;
    }

    /** Returns the number of rays that the last successful search has found. */
    int found() {
        int ofRow = 0;
        for (int part = 0; part < parts; part++) {
            ofRow += lastColumn[part] - firstColumn[part] + 1;
        }
        return ofRow * (lastRow - firstRow + 1);
    }

    int firstRow() {
        return firstRow;
    }

    int lastRow() {
        return lastRow;
    }

    /** Returns the number of intervals of columns, 1 or 2. */
    int parts() {
        return parts;
    }

    /** Returns the number of the first found ray of a row in an interval of columns. */
    int firstRay(int row, int part) {
        return row * columns + firstColumn[part];
    }

    /** Returns the number of the last found ray of a row in an interval of columns. */
    int lastRay(int row, int part) {
        return row * columns + lastColumn[part];
    }

    /**
     * Returns the turn of a direction from +Z towards +X, -2 to 2. It increases with the angle, and
     * is 1 for a right angle.
     */
    private static double turn(double sin, double cos) {
        double side = sin / (Math.abs(sin) + Math.abs(cos));
        if (cos >= 0) {
            return side;
        }
        return sin >= 0 ? BACK - side : -BACK - side;
    }

    /** Numbers in ascending order, and a table that finds the numbers in an interval. */
    private static final class Ascending {
        private final double least;
        private final double most;
        private final double perCell;

        /** Count of the numbers in the cells before each cell. */
        private final int[] before;

        Ascending(double[] numbers) {
            least = numbers[0];
            most = numbers[numbers.length - 1];
            int cells = 4 * numbers.length;
            perCell = most > least ? (cells - 1) / (most - least) : 0;
            before = new int[cells + 1];
            for (double number : numbers) {
                before[cell(number) + 1]++;
            }
            for (int cell = 0; cell < cells; cell++) {
                before[cell + 1] += before[cell];
            }
        }

        /**
         * Returns the cell of a number. Rounding is monotonic, so a smaller number is never in a
         * higher cell.
         */
        private int cell(double number) {
            return (int) ((number - least) * perCell);
        }

        /**
         * Returns an index that is at most the index of the first element not less than the number.
         */
        int first(double number) {
            return number > most
                    ? before[before.length - 1]
                    : before[number > least ? cell(number) : 0];
        }

        /** Returns an index that is at least the index of the last element not above the number. */
        int last(double number) {
            return number < least
                    ? -1
                    : before[number < most ? cell(number) + 1 : before.length - 1] - 1;
        }
    }
}
