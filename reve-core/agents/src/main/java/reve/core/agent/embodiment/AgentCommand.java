// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;

import java.util.function.Consumer;

/** An input of an agent as a command, executed on the world's thread in ACT. */
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

    /** Agents in lock-step do not delay operators' edits. */
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
