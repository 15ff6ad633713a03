// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** What became of an {@link AgentInput}. */
public sealed interface Outcome {

    /** It took effect in that frame. */
    record Done(long frame) implements Outcome {}

    /**
     * The agent has that body since that frame.
     *
     * @param sensors it perceives with; none for everything
     */
    record Joined(long frame, String body, ItemId id, List<Sensor> sensors) implements Outcome {}

    /**
     * Nothing happened.
     *
     * @param hint what to do about it
     */
    record Refused(long frame, String code, String reason, Optional<String> hint)
            implements Outcome {}

    /** The action has an error of its own, which is for whoever wrote it. */
    record Failed(long frame, Exception cause) implements Outcome {}

    /** The agent is not in the world: it never came in, which it has been told. */
    record Absent() implements Outcome {}
}
