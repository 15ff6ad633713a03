package reve.core.agent;

import java.util.function.Consumer;
import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;

/** What an agent wants of the world: done on the world's thread in ACT, answered on the event loop's. */
public final class AgentCommand implements Command {

    private final Publisher publisher;
    private final Members members;
    private final long sequence;
    private final AgentInput input;
    private final Consumer<Outcome> answer;

    /** @param answer told how it went, on the event loop's thread */
    AgentCommand(Publisher publisher, Members members, long sequence, AgentInput input, Consumer<Outcome> answer) {
        this.publisher = publisher;
        this.members = members;
        this.sequence = sequence;
        this.input = input;
        this.answer = answer;
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

    @Override
    public void execute(World world, FrameEvent event) {
        Outcome outcome = members.apply(world, event.frame(), input);
        publisher.later(() -> answer.accept(outcome));
    }
}
