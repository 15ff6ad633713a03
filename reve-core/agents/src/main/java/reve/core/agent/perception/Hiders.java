// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import java.util.Arrays;

/**
 * Which bodies hid others from an eye when it was looked last, the newest first. They are asked
 * first, as a few near the eye hide most of what is hidden; where none hides, nothing is lost but
 * the questions. One thread.
 */
final class Hiders {

    private static final int MOST = 12;

    private final int[] rows = new int[MOST];

    Hiders() {
        Arrays.fill(rows, SensedWorld.NOTHING);
    }

    int count() {
        return MOST;
    }

    /** A row, or {@link SensedWorld#NOTHING}; rows may be others by now. */
    int get(int place) {
        return rows[place];
    }

    /** The body in that place has hidden something again. */
    void toFront(int place) {
        int row = rows[place];
        System.arraycopy(rows, 0, rows, 1, place);
        rows[0] = row;
    }

    /** A body that is not here has hidden something. */
    void add(int row) {
        System.arraycopy(rows, 0, rows, 1, MOST - 1);
        rows[0] = row;
    }
}
