package reve.core.agent;

import reve.core.world.World;

/** Takes an agent out of the world; does nothing if it never came in. */
final class LeaveCommand extends AgentCommand {

    private final JoinCommand membership;
    private final String reason;

    LeaveCommand(Publisher publisher, JoinCommand membership, long sequence, String reason) {
        super(publisher, membership.origin(), sequence);
        this.membership = membership;
        this.reason = reason;
    }

    @Override
    void perform(World world, long frame) {
        membership.leave(world, frame, reason);
    }

    @Override
    void report() {
        // The connection has had its bye.
    }
}
