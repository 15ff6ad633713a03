package reve.core.agent;

import java.util.LinkedHashMap;
import java.util.Map;
import org.jspecify.annotations.Nullable;
import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;

/** What an agent wants of the world: done on the world's thread in ACT, answered on the publisher's. */
abstract sealed class AgentCommand implements Command permits JoinCommand, ActCommand, LeaveCommand {

    private final Publisher publisher;
    private final String agent;
    private final long sequence;

    /** The command that was completed before this one; kept by the publisher. */
    @Nullable AgentCommand previous;

    AgentCommand(Publisher publisher, String agent, long sequence) {
        this.publisher = publisher;
        this.agent = agent;
        this.sequence = sequence;
    }

    @Override
    public final String origin() {
        return agent;
    }

    @Override
    public final long sequence() {
        return sequence;
    }

    @Override
    public final void execute(World world, FrameEvent event) {
        try {
            perform(world, event.frame());
        } finally {
            publisher.completed(this);
        }
    }

    abstract void perform(World world, long frame);

    /** An event's fields from names and values in turn, in the order given. */
    static Map<String, Object> fields(String... namesAndValues) {
        var fields = new LinkedHashMap<String, Object>();
        for (int i = 0; i < namesAndValues.length; i += 2) {
            fields.put(namesAndValues[i], namesAndValues[i + 1]);
        }
        return fields;
    }

    /** Tells the agent how it went, on the publisher's thread. */
    abstract void report();
}
