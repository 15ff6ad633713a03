// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;

import java.util.function.Consumer;

/** What an agent wants of the world, done on the world's thread in ACT. */
public final class AgentCommand implements Command {

    private final Members members;
    private final long sequence;
    private final AgentInput input;
    private final Consumer<Outcome> done;

    /**
     * @param done told how it went, on the world's thread
     */
    AgentCommand(Members members, long sequence, AgentInput input, Consumer<Outcome> done) {
        this.members = members;
        this.sequence = sequence;
        this.input = input;
        this.done = done;
    }

    /** What is wanted, for whoever records it. */
    public AgentInput input() {
        return input;
    }

    @Override
    public String origin() {
        return input.agent();
    }

    @Override
    public long sequence() {
        return sequence;
    }

    /** An operator's hand is not held up by agents in lock-step. */
    @Override
    public boolean isPrompt() {
        return input instanceof AgentInput.Edit;
    }

    @Override
    public boolean mustWait(FrameEvent event) {
        return input instanceof AgentInput.Act && !members.mayAct(input.agent(), event.frame());
    }

    @Override
    public void execute(World world, FrameEvent event) {
        done.accept(members.apply(world, event.frame(), input));
    }
}
