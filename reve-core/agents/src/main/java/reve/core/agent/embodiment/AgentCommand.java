// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;

import java.util.function.Consumer;

/**
 * A command of the frame loop that applies an input of an agent, on the world's thread in the phase
 * ACT.
 */
public final class AgentCommand implements Command {

    private final Embodiment embodiment;
    private final long sequence;
    private final AgentInput input;
    private final Consumer<Outcome> done;

    /**
     * @param done receives the outcome on the world's thread
     */
    public AgentCommand(
            Embodiment embodiment, long sequence, AgentInput input, Consumer<Outcome> done) {
        this.embodiment = embodiment;
        this.sequence = sequence;
        this.input = input;
        this.done = done;
    }

    @Override
    public String origin() {
        return input.agent();
    }

    @Override
    public long sequence() {
        return sequence;
    }

    /** Returns true for operators' edits, which do not wait for agents in lock-step. */
    @Override
    public boolean isPrompt() {
        return input instanceof AgentInput.Edit;
    }

    @Override
    public boolean mustWait(FrameEvent event) {
        return input instanceof AgentInput.Act
                && !embodiment.mayAct(event.world(), input.agent(), event.frame());
    }

    @Override
    public void execute(World world, FrameEvent event) {
        done.accept(embodiment.apply(world, event.frame(), input));
    }
}
