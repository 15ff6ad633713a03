// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import java.util.Arrays;

/**
 * The bodies that last hid other bodies from an eye, which is the origin of an agent's body. The
 * body that hid another one most recently comes first. Line-of-sight tests check these bodies
 * first, because a few bodies near the eye hide most others. For one thread.
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

    /**
     * Returns the row of a body, or {@link SensedWorld#NOTHING} if the place is empty. The row may
     * contain a different body than before.
     */
    int get(int place) {
        return rows[place];
    }

    /** Moves the body at an index to the front, because it has hidden a body again. */
    void toFront(int place) {
        int row = rows[place];
        System.arraycopy(rows, 0, rows, 1, place);
        rows[0] = row;
    }

    /** Adds a body that has hidden another one. */
    void add(int row) {
        System.arraycopy(rows, 0, rows, 1, MOST - 1);
        rows[0] = row;
    }
}
