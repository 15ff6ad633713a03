// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** The result of applying an {@link AgentInput}. */
public sealed interface Outcome {

    /** The input took effect in that frame. */
    record Done(long frame) implements Outcome {}

    /**
     * The agent joined the world and has the body from that frame on.
     *
     * @param sensors sensors of the body; if empty, the agent perceives everything
     */
    record Joined(long frame, String body, ItemId id, List<Sensor> sensors) implements Outcome {}

    /**
     * The input was refused, and nothing changed.
     *
     * @param hint what the client can do about it
     */
    record Refused(long frame, String code, String reason, Optional<String> hint)
            implements Outcome {}

    /**
     * The action failed because of an error in its code. The error is logged for the author of the
     * action.
     */
    record Failed(long frame, Exception cause) implements Outcome {}

    /** The agent is not in the world, because its join was refused. No further answer is sent. */
    record Absent() implements Outcome {}
}
