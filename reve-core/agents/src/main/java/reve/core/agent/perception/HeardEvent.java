// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;
import reve.core.world.WorldEvent;

import java.util.BitSet;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * An event in the form that is sent to clients. It is created and encoded once for all clients that
 * receive the same fields. For the event loop's thread only.
 */
public final class HeardEvent {

    private final WorldEvent event;
    private final Map<Hearing, Told> told = new HashMap<>(2);

    private record Hearing(BitSet fields, Encoding encoding) {}

    /**
     * An event with the fields that some clients receive, and its encoded form.
     *
     * @param bytes the encoded message; must not change
     * @param encoding encoding of the bytes
     */
    public record Told(ServerMessage.Event message, byte[] bytes, Encoding encoding) {

        /** Encodes an event. */
        public static Told of(ServerMessage.Event message, Encoding encoding) {
            return new Told(message, message.in(encoding), encoding);
        }

        /**
         * Returns the message in an encoding: the shared bytes if the encoding is the same,
         * otherwise a newly encoded copy.
         */
        public byte[] in(Encoding wanted) {
            return wanted == encoding ? bytes : message.in(wanted);
        }
    }

    /** Wraps an event of the world; it is encoded when it is first sent. */
    public HeardEvent(WorldEvent event) {
        this.event = event;
    }

    /** Returns the event with all its fields. */
    public WorldEvent event() {
        return event;
    }

    /**
     * Returns the event with only some of its fields.
     *
     * @param fields indices of the fields that are sent
     */
    public Told with(BitSet fields, Encoding encoding) {
        return told.computeIfAbsent(new Hearing(fields, encoding), this::make);
    }

    private Told make(Hearing hearing) {
        var fields = new LinkedHashMap<String, Object>();
        int place = 0;
        for (Map.Entry<String, Object> field : event.fields().entrySet()) {
            if (hearing.fields.get(place++)) {
                fields.put(field.getKey(), field.getValue());
            }
        }
        return Told.of(
                new ServerMessage.Event(event.frame(), event.type(), fields), hearing.encoding);
    }
}
