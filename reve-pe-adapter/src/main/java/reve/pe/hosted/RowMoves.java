// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

/**
 * Moves of rows of a kind.
 *
 * @param rows two numbers, from and to, for each move
 */
record RowMoves(String kind, long[] rows) {
    /**
     * Maximum count of row numbers in one request, two for each move; the mailbox has more room.
     */
    private static final int ROWS_PER_REQUEST = 2 * 16 * 1024;

    /** Makes the moves in a host. */
    void send(Calls calls) throws HostLost {
        for (int at = 0; at < rows.length; at += ROWS_PER_REQUEST) {
            int begin = at;
            int end = Math.min(rows.length, at + ROWS_PER_REQUEST);
            calls.call(
                    to -> {
                        Mailbox request = to.begin(Request.MOVE_ROWS).putText(kind);
                        request.putInt((end - begin) / 2);
                        for (int i = begin; i < end; i++) {
                            request.putLong(rows[i]);
                        }
                    });
        }
    }
}
