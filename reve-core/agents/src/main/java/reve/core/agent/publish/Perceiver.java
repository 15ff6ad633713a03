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

/** A client as its world's publisher sees it. The event loop's thread. */
public interface Perceiver extends PerceptionShares.Client, RelatedViews.Client {

    /** Returns the name that the client declared. */
    String name();

    /** Returns the name of its body; empty if it has none. */
    Optional<String> body();

    /** Returns how messages to it are written. */
    Encoding encoding();

    /** Returns what it has asked to perceive over its newest connection. */
    PerceptionRequests perceptions();

    /** Returns true if it perceives only what the sensors of its body sense. */
    boolean hasSensors();

    /** Gives it a body, another one than before perhaps, or ends it if there is none for it. */
    void embodied(Outcome outcome);

    /** Returns what it perceives of the newest frame. */
    View look(Observatory world);

    /**
     * Returns which fields of an event it is sent, by their place; empty if it is not sent the
     * event.
     */
    Optional<BitSet> hear(WorldEvent event, EventSubjects subjects, Observatory world);

    /** Writes the box that its sensors reach, see {@link Observatory#reach}. */
    boolean reach(Observatory world, double[] lows, double[] highs, int at);

    /** Sends it an event. */
    void tell(HeardEvent.Told event);

    /** Notes that it is not sent so many events, at most, of these frames. */
    void miss(long events, long first, long last);
}
