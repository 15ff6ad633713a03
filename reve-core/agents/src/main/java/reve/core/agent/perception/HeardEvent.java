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
 * An event as agents hear of it, made and encoded once for all who are told the same. The event
 * loop's thread.
 */
public final class HeardEvent {

    private final WorldEvent event;
    private final Map<Hearing, Told> told = new HashMap<>(2);

    private record Hearing(BitSet fields, Encoding encoding) {}

    /**
     * @param bytes the message as it goes over the wire; never changed
     * @param encoding of the bytes
     */
    public record Told(ServerMessage.Event message, byte[] bytes, Encoding encoding) {

        /** Encodes an event. */
        public static Told of(ServerMessage.Event message, Encoding encoding) {
            return new Told(message, message.in(encoding), encoding);
        }

        /** Returns the message as bytes, which are shared if they are in that encoding. */
        public byte[] in(Encoding wanted) {
            return wanted == encoding ? bytes : message.in(wanted);
        }
    }

    /** An event that is encoded when it is first sent. */
    public HeardEvent(WorldEvent event) {
        this.event = event;
    }

    /** Returns the event with all its fields. */
    public WorldEvent event() {
        return event;
    }

    /**
     * @param fields which of the event's fields are told, by their place
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
