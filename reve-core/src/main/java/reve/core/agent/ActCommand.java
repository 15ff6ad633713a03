package reve.core.agent;

import java.util.List;
import org.jspecify.annotations.Nullable;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.World;
import reve.core.world.WorldEvent;

/** An agent's use of an action. Whether it may happen is decided here and nowhere else. */
final class ActCommand extends AgentCommand {

    private final Session session;
    private final JoinCommand membership;
    private final ClientMessage.Act act;
    private ServerMessage.@Nullable Refused refusal;
    private @Nullable RuntimeException failure;
    private boolean performed;
    private long frame;

    ActCommand(Publisher publisher, Session session, JoinCommand membership, long sequence, ClientMessage.Act act) {
        super(publisher, membership.origin(), sequence);
        this.session = session;
        this.membership = membership;
        this.act = act;
    }

    @Override
    void perform(World world, long inFrame) {
        if (!membership.isMember()) {
            return; // its hello was refused, which is the answer to this too
        }
        frame = inFrame;
        try {
            Item item = world.find(act.item()).orElseThrow(() -> new ActionRefused("no-such-item",
                    "the world has no item " + Text.quote(act.item())));
            Action action = item.access().find(act.action()).orElseThrow(() -> noSuchAction(item));
            var call = new ActionCall(world, inFrame, item, membership.body(world),
                    Arguments.check(action, act.arguments()));
            action.perform(call);
            performed = true;
            raiseActed(world);
        } catch (ActionRefused e) {
            refusal = new ServerMessage.Refused(act.id(), e.code(), e.getMessage());
        } catch (RuntimeException e) {
            failure = e;
            refusal = new ServerMessage.Refused(act.id(), "action-failed",
                    "the action " + Text.quote(act.action()) + " failed; the server's log says why");
        }
    }

    @Override
    void report() {
        if (performed) {
            session.acted(new ServerMessage.Accepted(act.id(), frame), frame);
        } else if (refusal != null) {
            session.acted(refusal, frame);
        }
        if (failure != null) {
            session.actionFailed(act, failure);
        }
    }

    private void raiseActed(World world) {
        world.raise(new WorldEvent(frame, "acted",
                fields("agent", origin(), "item", act.item(), "action", act.action())));
    }

    private ActionRefused noSuchAction(Item item) {
        List<String> names = item.access().actions().stream().map(Action::name).toList();
        return new ActionRefused("no-such-action", "the item " + Text.quote(item.name()) + " has no action "
                + Text.quote(act.action()) + (names.isEmpty() ? "; it has none" : "; it has " + names));
    }
}
