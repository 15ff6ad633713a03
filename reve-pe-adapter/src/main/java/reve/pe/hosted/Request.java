// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

/** The requests that a host answers, numbered from 1 as in {@code vesper-native/host}. */
enum Request {
    CREATE,
    ADD,
    REBIND,
    REMOVE,
    FIND,
    TOUCH,
    PREPARE,
    LOAD,
    UNLOAD,
    LAWS,
    ADVANCE,
    CLEAR_FAULT,
    MOVE_ROWS,
    SET_STEP_COUNT,
    STATE_HASH,
    STATE_MEMORY,
    SAVE_STATE,
    LOAD_STATE,
    SET_LEDGER,
    LEDGER,
    BIND_ALL,
    SET_INTERVAL,
    BEGIN_CHANGES,
    END_CHANGES,
    REPLACE,
    SCRATCH_ROW;

    int number() {
        return ordinal() + 1;
    }
}
