// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

/** The place where a world keeps the notes about its sessions. For any thread. */
@FunctionalInterface
public interface SessionNotes {
    /** The value for a world that keeps no notes. */
    SessionNotes NONE =
            new SessionNotes() {
                @Override
                public void add(SessionNote note) {
                    // A world without a shared store is continued by no other server.
                }

                @Override
                public boolean areKept() {
                    return false;
                }
            };

    /**
     * Adds a note. A note that the world's thread adds in the phase ACT is stored together with
     * that frame, either both or none.
     */
    void add(SessionNote note);

    /** Returns whether notes are kept. Otherwise, they need not be written. */
    default boolean areKept() {
        return true;
    }
}
