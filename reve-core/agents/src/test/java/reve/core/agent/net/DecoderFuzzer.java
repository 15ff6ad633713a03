// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.MessageReader;
import reve.core.agent.protocol.ServerMessage;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.ReadableByteChannel;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/**
 * The entry point for Jazzer. The first byte chooses the decoder: a message of JSON or of
 * MessagePack, or a stream in pieces.
 */
public final class DecoderFuzzer {

    private static final int MAX_TEXT = 2000;
    private static final AgentTimeouts TIMEOUTS = AgentTimeouts.PROTOCOL;
    private static final AgentServerConfig CONFIG =
            AgentRoom.config(TIMEOUTS.hello(), TIMEOUTS.line(), TIMEOUTS.idle(), TIMEOUTS.write());

    private DecoderFuzzer() {}

    /** Throws if the input reveals a bug. */
    public static void fuzzerTestOneInput(byte[] data) throws IOException {
        if (data.length == 0) {
            return;
        }
        byte[] bytes = Arrays.copyOfRange(data, 1, data.length);
        Encoding encoding = Encoding.values()[(data[0] & 1)];
        if ((data[0] & 2) == 0) {
            read(ByteBuffer.wrap(bytes), encoding);
        } else {
            int piece = 1 + (data[0] >> 2 & 31);
            List<String> whole = cut(bytes, encoding, Integer.MAX_VALUE);
            List<String> pieces = cut(bytes, encoding, piece);
            if (!whole.equals(pieces)) {
                throw new AssertionError(
                        "in pieces of " + piece + ": " + pieces + ", whole: " + whole);
            }
        }
    }

    /** Decodes a message. Throws if a refusal has no code or no printable reason. */
    private static void read(ByteBuffer bytes, Encoding encoding) {
        try {
            ClientMessage message = MessageReader.read(bytes, encoding);
            require(message.id() >= ClientMessage.NO_ID, "an id of " + message.id());
        } catch (BadMessage e) {
            ServerMessage.Error error = e.error();
            for (String text : List.of(error.code(), error.message(), error.hint())) {
                require(!text.isEmpty() && text.length() < MAX_TEXT, "a text of " + text.length());
            }
            error.in(encoding);
        }
    }

    /**
     * Returns the messages of a stream and the way in which it ends. Both must be the same for all
     * divisions into pieces.
     */
    private static List<String> cut(byte[] bytes, Encoding encoding, int piece) throws IOException {
        var found = new ArrayList<String>();
        var messages = new MessageFramer(CONFIG.limits(), CONFIG.timeouts(), () -> {});
        messages.greeted(encoding);
        var stream = new Stream(ByteBuffer.wrap(bytes), piece);
        try {
            while (messages.fill(stream)) {
                for (ByteBuffer next = messages.next(); next != null; next = messages.next()) {
                    byte[] message = new byte[next.remaining()];
                    next.get(message);
                    found.add(Arrays.toString(message));
                }
            }
        } catch (CloseReason e) {
            found.add(e.code());
        }
        return found;
    }

    private static void require(boolean fact, String otherwise) {
        if (!fact) {
            throw new AssertionError(otherwise);
        }
    }

    /** A stream that returns at most {@code piece} bytes at a time. */
    private record Stream(ByteBuffer bytes, int piece) implements ReadableByteChannel {

        @Override
        public int read(ByteBuffer into) {
            int count = Math.min(piece, Math.min(into.remaining(), bytes.remaining()));
            into.put(bytes.slice().limit(count));
            bytes.position(bytes.position() + count);
            return count == 0 && !bytes.hasRemaining() ? -1 : count;
        }

        @Override
        public boolean isOpen() {
            return true;
        }

        @Override
        public void close() {
            // There is nothing to close.
        }
    }
}
