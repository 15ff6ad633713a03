// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/** The result of applying an {@link AgentInput}. */
public sealed interface Outcome {

    /**
     * Reports that the input took effect in the given frame.
     *
     * @param value the field {@code value} of the result, see {@link
     *     reve.core.agent.protocol.ServerMessage.Answer}
     */
    record Done(long frame, Optional<Object> value) implements Outcome {

        /** Creates an outcome without a value. */
        public Done(long frame) {
            this(frame, Optional.empty());
        }
    }

    /**
     * Reports that the agent joined the world, and has the body from the given frame on.
     *
     * @param sensors sensors of the body; if empty, the agent perceives everything
     */
    record Joined(long frame, String body, ItemId id, List<Sensor> sensors) implements Outcome {}

    /**
     * Reports that the input was refused and that nothing changed.
     *
     * @param hint advice for the client
     */
    record Refused(long frame, String code, String reason, Optional<String> hint)
            implements Outcome {}

    /**
     * Reports that the action failed because of an error in its code. The error is logged for the
     * author of the action.
     */
    record Failed(long frame, Exception cause) implements Outcome {}

    /**
     * Reports that the agent is not in the world, because its join was refused. The refusal was
     * already sent, so the client receives no further answer.
     */
    record Absent() implements Outcome {}
}
