// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import java.util.Optional;

/** A message to the actor of a world. */
sealed interface WorldCommand {
    /** Asks the node to run the world. Also sent between nodes. */
    record Wake() implements WorldCommand {
        static final Wake INSTANCE = new Wake();
    }

    /** Asks the node to close the world, because another node shall run it or this one ends. */
    record Stop() implements WorldCommand {}

    /**
     * Reports that the world was closed.
     *
     * @param reason why, if it was not stopped
     */
    record Closed(Optional<String> reason) implements WorldCommand {}
}
