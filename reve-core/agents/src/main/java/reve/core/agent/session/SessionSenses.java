// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.embodiment.Outcome;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceivedItem;
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
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BooleanSupplier;

/**
 * The perception of a session's client. A client perceives either everything or the items that the
 * sensors of its body reach. For the event loop's thread only.
 */
final class SessionSenses {
    /** Maximum number of names in a report. */
    private static final int MOST_NAMES = 1000;

    private final Role role;

    /** The sensors of the body; null for a client that perceives everything. */
    private @Nullable Senses senses;

    /** The body; null for a client without a body. */
    private @Nullable ItemId body;

    /** The last view of a client that perceives everything. */
    private View everything = new View(0, 0, List.of());

    SessionSenses(Role role) {
        this.role = role;
    }

    /** Sets the body of the agent, which may replace an earlier body. */
    void embody(Outcome.Joined joined) {
        body = joined.id();
        everything = new View(0, 0, List.of());
        senses = joined.sensors().isEmpty() ? null : new Senses(joined.id(), joined.sensors());
    }

    boolean areLimited() {
        return senses != null;
    }

    /**
     * Describes for a report what the client perceived last. A client that perceives everything has
     * no list.
     */
    Map<String, Object> describe() {
        var fields = new LinkedHashMap<String, Object>();
        Senses known = senses;
        fields.put("everything", known == null);
        if (known != null) {
            View last = known.lastView();
            if (last.frame() > 0) {
                fields.put("frame", last.frame());
            }
            fields.put("count", last.items().size());
            fields.put(
                    "items",
                    last.items().stream().limit(MOST_NAMES).map(PerceivedItem::name).toList());
        }
        return fields;
    }

    /** Returns the names of the body's cameras. */
    List<String> cameras() {
        Senses known = senses;
        return known == null ? List.of() : BodyCamera.names(known.sensors());
    }

    Optional<View> look(Observatory world, BooleanSupplier isTimeLeft) {
        if (senses != null) {
            return senses.look(world, isTimeLeft);
        }
        if (body == null) {
            return Optional.of(world.everything());
        }
        everything = world.everythingOf(body, everything);
        return Optional.of(everything);
    }

    Optional<Set<ItemId>> sensedIn(long frame) {
        return senses == null ? Optional.empty() : senses.sensedIn(frame);
    }

    View relate(View view, Optional<Set<ItemId>> fresh) {
        return senses == null || fresh.isEmpty() ? view : senses.relate(view, fresh.get());
    }

    boolean needsSight() {
        return senses != null && senses.needsSight();
    }

    boolean reach(Observatory world, double[] lows, double[] highs, int at) {
        return senses != null && senses.reach(world, lows, highs, at);
    }

    /**
     * Returns the indices of the fields of an event that are sent to the client, see {@link
     * Senses#hear}. A client without sensors receives all fields. Only the role control receives
     * the message of a fault or of a refused law, because the message may name files of the server.
     */
    Optional<BitSet> hear(
            WorldEvent event, EventSubjects subjects, Observatory world, boolean searches) {
        if (senses != null) {
            return senses.hear(event, subjects, world, searches);
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
                    BodyCamera.hint(cameras()));
        }
        requests.take(look, known.body(), camera.get());
    }
}
