// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.embodiment.Outcome;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.Senses;
import reve.core.agent.perception.View;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.Text;
import reve.core.agent.publish.CameraRequests;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.WorldEvent;

import java.util.BitSet;
import java.util.Optional;
import java.util.Set;
import java.util.function.BooleanSupplier;

/**
 * The perception of a session's client. A client perceives either everything or the items that the
 * sensors of its body reach. For the event loop's thread only.
 */
final class SessionSenses {
    private final Role role;

    /** The sensors of the body; null for a client that perceives everything. */
    private @Nullable Senses senses;

    SessionSenses(Role role) {
        this.role = role;
    }

    /** Sets the body of the agent, possibly another one than before. */
    void embody(Outcome.Joined joined) {
        senses = joined.sensors().isEmpty() ? null : new Senses(joined.id(), joined.sensors());
    }

    boolean areLimited() {
        return senses != null;
    }

    Optional<View> look(Observatory world, BooleanSupplier isTimeLeft) {
        return senses == null ? Optional.of(world.everything()) : senses.look(world, isTimeLeft);
    }

    Optional<Set<ItemId>> sensedIn(long frame) {
        return senses == null ? Optional.empty() : senses.sensedIn(frame);
    }

    View relate(View view, Optional<Set<ItemId>> fresh) {
        return senses == null || fresh.isEmpty() ? view : senses.relate(view, fresh.get());
    }

    boolean reach(Observatory world, double[] lows, double[] highs, int at) {
        return senses != null && senses.reach(world, lows, highs, at);
    }

    /**
     * Returns the indices of the fields of an event that are sent to the client, see {@link
     * Senses#hear}. A client without sensors receives all fields. Only the role control receives
     * the message of a fault or of a refused law, because the message may name files of the server.
     */
    Optional<BitSet> hear(WorldEvent event, EventSubjects subjects, Observatory world) {
        if (senses != null) {
            return senses.hear(event, subjects, world);
        }
        var fields = new BitSet();
        fields.set(0, event.fields().size());
        if (role != Role.CONTROL && Senses.FOR_OPERATORS.contains(event.type())) {
            int place = 0;
            for (String field : event.fields().keySet()) {
                fields.set(place++, !field.equals("message"));
            }
        }
        return Optional.of(fields);
    }

    /**
     * Requests a picture from a camera of the body.
     *
     * @param client names the client in a refusal
     */
    void look(ClientMessage.Look look, CameraRequests requests, Object client) throws BadMessage {
        Senses known = senses;
        Optional<Sensor> camera = known == null ? Optional.empty() : known.camera(look.sensor());
        if (known == null || camera.isEmpty()) {
            throw new BadMessage(
                    look.id(),
                    "no-such-camera",
                    client + " has no camera " + Text.quote(look.sensor()),
                    "the world file says which sensors a body has");
        }
        requests.take(look, known.body(), camera.get());
    }
}
