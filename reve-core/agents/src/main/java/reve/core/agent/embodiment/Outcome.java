// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** The outcome of an {@link AgentInput}. */
public sealed interface Outcome {

    /** The input took effect in that frame. */
    record Done(long frame) implements Outcome {}

    /**
     * The agent has the body from that frame.
     *
     * @param sensors of the body; if empty, the agent perceives everything
     */
    record Joined(long frame, String body, ItemId id, List<Sensor> sensors) implements Outcome {}

    /**
     * The input was refused, and nothing changed.
     *
     * @param hint the remedy
     */
    record Refused(long frame, String code, String reason, Optional<String> hint)
            implements Outcome {}

    /** The action failed because of an error in its code, for its author. */
    record Failed(long frame, Exception cause) implements Outcome {}

    /** The agent is not in the world because its join was refused, which it knows. */
    record Absent() implements Outcome {}
}
