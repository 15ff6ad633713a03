// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.MessageWriter;
import reve.core.agent.protocol.Rope;

import java.util.EnumMap;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;

/** Encoder of perceptions. Data of a frame that several agents receive is encoded once. */
public final class PerceptionEncoder {
    /**
     * Maximum size of a perception [bytes]. All clients of a server wait while a perception is
     * encoded, so a world with long texts in many items must not delay the clients of other worlds.
     */
    public static final int MOST_BYTES = 64 << 20;

    /** Encoded fields by view and encoding. Guarded by this object's lock. */
    private final Map<View, Map<Encoding, Fields>> told = new IdentityHashMap<>();

    private @Nullable View shared;

    /**
     * The encoded fields of a perception. The fields {@code t} (the type) and {@code id} are not
     * included; a message begins with them.
     */
    private record Fields(int count, Rope encoded) {}

    /**
     * Begins a new frame, or continues with the same one. No other thread may be writing.
     *
     * @param everything the view that all clients without sensors receive
     */
    public synchronized void begin(View everything) {
        if (everything != shared) {
            told.clear();
            shared = everything;
        }
    }

    /**
     * Appends an encoded perception. Several threads may call it at the same time.
     *
     * @param difference a reusable object for the comparison of views
     * @param id id of the message that the perception answers
     * @param before the client's previous view; null for a full perception
     * @throws TooLarge if the perception has more than {@link #MOST_BYTES} bytes
     */
    public void write(
            Bytes out,
            Difference difference,
            Encoding encoding,
            long id,
            View view,
            @Nullable View before) {
        int start = out.size();
        if (view == shared) {
            Fields fields = sharedFields(difference, encoding, view, before);
            encoding.begin(out, "perception", id, fields.count);
            out.put(fields.encoded);
        } else if (before == null) {
            int readings = Reading.isAnyNewerThan(Long.MIN_VALUE, view) ? 1 : 0;
            MessageWriter writer = encoding.begin(out, "perception", id, 3 + readings);
            writeWhole(writer, out, view);
            Reading.write(writer, view, Long.MIN_VALUE);
        } else {
            difference.find(before.items(), view.items());
            int readings = Reading.isAnyNewerThan(before.frame(), view) ? 1 : 0;
            MessageWriter writer =
                    encoding.begin(out, "perception", id, 3 + difference.lists() + readings);
            writeDifference(writer, out, difference, view, before);
            Reading.write(writer, view, before.frame());
        }
        encoding.end(out, start);
    }

    /**
     * Returns the cached fields. The key of a full perception is its view. The key of a difference
     * is the previous view.
     */
    private synchronized Fields sharedFields(
            Difference difference, Encoding encoding, View view, @Nullable View before) {
        return told.computeIfAbsent(
                        before == null ? view : before, unknown -> new EnumMap<>(Encoding.class))
                .computeIfAbsent(encoding, unknown -> fields(difference, encoding, view, before));
    }

    private static Fields fields(
            Difference difference, Encoding encoding, View view, @Nullable View before) {
        var out = new Bytes();
        MessageWriter writer = encoding.fields(out);
        if (before == null) {
            writeWhole(writer, out, view);
            return new Fields(3, out.rope(0));
        }
        difference.find(before.items(), view.items());
        writeDifference(writer, out, difference, view, before);
        return new Fields(3 + difference.lists(), out.rope(0));
    }

    private static void writeWhole(MessageWriter writer, Bytes out, View view) {
        writeTime(writer, view);
        writer.key("items");
        List<PerceivedItem> items = view.items();
        writer.beginList(items.size());
        for (int i = 0; i < items.size(); i++) {
            writer.fragment(items.get(i).whole());
            requireSize(out);
        }
        writer.endList();
    }

    private static void writeDifference(
            MessageWriter writer, Bytes out, Difference difference, View view, View before) {
        writeTime(writer, view);
        writer.key("since");
        writer.integer(before.frame());
        difference.write(writer, out);
    }

    static void requireSize(Bytes out) {
        if (out.size() > MOST_BYTES) {
            throw new TooLarge();
        }
    }

    /** Thrown if a perception has more than {@link #MOST_BYTES} bytes. It has no stack trace. */
    public static final class TooLarge extends RuntimeException {
        private static final long serialVersionUID = 1L;

        private TooLarge() {
            super(
                    "a perception of this world has more than "
                            + (MOST_BYTES >> 20)
                            + " MiB; shorten the symbols and actions of its items, or perceive"
                            + " fewer items",
                    null,
                    false,
                    false);
        }
    }

    private static void writeTime(MessageWriter writer, View view) {
        writer.key("frame");
        writer.integer(view.frame());
        writer.key("time");
        writer.number(view.time());
    }
}
