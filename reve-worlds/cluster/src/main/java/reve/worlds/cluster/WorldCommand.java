// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.actor.typed.ActorRef;

import java.util.Optional;

/** A message to the actor of a world. */
sealed interface WorldCommand {
    /** Asks the node to run the world. Nodes also send this message to each other. */
    record Wake() implements WorldCommand {
        static final Wake INSTANCE = new Wake();
    }

    /**
     * Asks for the frames of the world, if the node runs it now. Nodes also send this message to
     * each other.
     *
     * @param reader receives the answer
     */
    record Watch(ActorRef<FrameOffer> reader) implements WorldCommand {}

    /**
     * Asks the node to close the world, because another node shall run the world or this node ends.
     */
    record Stop() implements WorldCommand {}

    /**
     * Reports that the world was closed.
     *
     * @param reason the reason; empty if the world was stopped
     */
    record Closed(Optional<String> reason) implements WorldCommand {}
}
