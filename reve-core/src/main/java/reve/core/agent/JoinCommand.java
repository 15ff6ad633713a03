package reve.core.agent;

import java.util.Optional;
import org.jspecify.annotations.Nullable;
import reve.core.world.Item;
import reve.core.world.World;
import reve.core.world.WorldEvent;

/** Gives an agent its body; from then on it is the agent's membership in the world. */
final class JoinCommand extends AgentCommand {

    private final Session session;
    private final Bodies bodies;
    private final Optional<String> wanted;
    private Bodies.@Nullable Body body;
    private long frame;
    private @Nullable Ending refusal;

    /** @param wanted the lent item that the agent asks for */
    JoinCommand(Publisher publisher, Session session, String agent, long sequence, Bodies bodies,
            Optional<String> wanted) {
        super(publisher, agent, sequence);
        this.session = session;
        this.bodies = bodies;
        this.wanted = wanted;
    }

    @Override
    void perform(World world, long inFrame) {
        try {
            Bodies.Body taken = bodies.take(world, origin(), wanted);
            body = taken;
            frame = inFrame;
            world.raise(new WorldEvent(inFrame, "joined", fields("agent", origin(), "body", taken.name())));
        } catch (Ending e) {
            refusal = e;
        } catch (RuntimeException e) {
            refusal = Ending.refused("no-body-free", "the body could not be made: " + e.getMessage(),
                    "correct agents.body in the world file");
        }
    }

    @Override
    void report() {
        Bodies.Body taken = body;
        if (taken != null) {
            session.welcome(taken.name(), frame);
        } else if (refusal != null) {
            session.end(refusal);
        }
    }

    /** World's thread: the body, if the agent has one that is still in the world. */
    Optional<Item> body(World world) {
        Bodies.Body mine = body;
        return mine == null ? Optional.empty()
                : world.find(mine.name()).filter(item -> item.id().equals(mine.id()));
    }

    /** World's thread: true while the agent is in the world. */
    boolean isMember() {
        return body != null;
    }

    /** World's thread: gives the body back. */
    void leave(World world, long inFrame, String reason) {
        Bodies.Body mine = body;
        if (mine != null) {
            body = null;
            bodies.giveBack(world, mine);
            world.raise(new WorldEvent(inFrame, "left",
                    fields("agent", origin(), "body", mine.name(), "reason", reason)));
        }
    }
}
