package reve.core.agent;

import java.util.Arrays;

/**
 * Which body hid which from an eye when it was looked at last. It is asked first, as it probably
 * still does; where it does not, nothing is lost. One thread.
 */
final class Hiders {

    private static final int SLOTS = 512;

    private final int[] rows = new int[SLOTS];

    Hiders() {
        Arrays.fill(rows, SensedWorld.NOTHING);
    }

    /** What may hide a body, by its row; {@link SensedWorld#NOTHING} if nothing is known. */
    int of(int row) {
        return rows[row % SLOTS];
    }

    void put(int row, int hider) {
        rows[row % SLOTS] = hider;
    }
}
