// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import reve.core.agent.embodiment.Outcome;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionShares;
import reve.core.agent.perception.RelatedViews;
import reve.core.agent.perception.View;
import reve.core.agent.protocol.Encoding;
import reve.core.world.WorldEvent;

import java.util.BitSet;
import java.util.Optional;
import java.util.function.BooleanSupplier;

/**
 * The interface through which the publisher of a world uses a client. For the event loop's thread
 * only.
 */
public interface Perceiver extends PerceptionShares.Client, RelatedViews.Client {

    /** Returns the name that the client declared. */
    String name();

    /** Returns the name of the client's body; empty if it has none. */
    Optional<String> body();

    /** Returns the encoding of messages to the client. */
    Encoding encoding();

    /** Returns the requests for perceptions that the client has made over its newest connection. */
    PerceptionRequests perceptions();

    /** Returns whether the client perceives only through sensors of its body. */
    boolean hasSensors();

    /**
     * Assigns a body to the client, which may replace an earlier body. Ends the client's session if
     * the outcome is a refusal.
     */
    void embodied(Outcome outcome);

    /**
     * Returns the client's view of the frame that was read.
     *
     * @param isTimeLeft false if other clients must be served first
     * @return empty if the time was too short; the next call in this frame continues
     */
    Optional<View> look(Observatory world, BooleanSupplier isTimeLeft);

    /** Returns whether one of its body's sensors needs a line of sight. */
    boolean needsSight();

    /**
     * Returns the indices of the event's fields that are sent to the client; empty if the event is
     * not sent.
     *
     * @param searches false if only the client's last view decides what it perceives
     */
    Optional<BitSet> hear(
            WorldEvent event, EventSubjects subjects, Observatory world, boolean searches);

    /**
     * Computes a box that contains the reach of the client's sensors. See {@link
     * Observatory#reach}.
     */
    boolean reach(Observatory world, double[] lows, double[] highs, int at);

    /** Sends an event to the client. */
    void tell(HeardEvent.Told event);

    /**
     * Records that up to {@code events} events of the frames {@code first} to {@code last} were not
     * sent.
     */
    void miss(long events, long first, long last);
}
