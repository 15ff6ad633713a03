// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import org.jspecify.annotations.Nullable;

import java.util.function.Consumer;

/**
 * A value that is encoded once, when it is first needed, and shared by all messages that contain
 * it. Several threads may need the value at the same time. Each of them may then encode it, with
 * the same result.
 */
public final class Fragment {

    private final Consumer<MessageWriter> content;
    private volatile @Nullable Rope json;
    private volatile @Nullable Rope packed;

    /**
     * @param content writes the value
     */
    public Fragment(Consumer<MessageWriter> content) {
        this.content = content;
    }

    /** Returns the encoded value; the caller must not change the bytes. */
    public byte[] in(Encoding encoding) {
        Rope known = known(encoding);
        return known != null
                ? known.flat()
                : keep(encoding, new Rope(encoding.value(content))).flat();
    }

    /**
     * Encodes the value now, so that no message has to wait for it.
     *
     * @param scratch a buffer that is overwritten
     */
    public void encode(Encoding encoding, Bytes scratch) {
        if (known(encoding) == null) {
            write(encoding.writer(scratch.clear()), scratch);
        }
    }

    /**
     * Writes the value at the writer's position.
     *
     * @param out the buffer to which the writer writes
     */
    void write(MessageWriter writer, Bytes out) {
        Encoding encoding = writer.encoding();
        Rope known = known(encoding);
        if (known == null) {
            int start = out.size();
            content.accept(writer);
            known = keep(encoding, out.rope(start));
            out.truncate(start);
        }
        out.put(known);
    }

    private @Nullable Rope known(Encoding encoding) {
        return encoding == Encoding.JSON ? json : packed;
    }

    private Rope keep(Encoding encoding, Rope encoded) {
        if (encoding == Encoding.JSON) {
            json = encoded;
        } else {
            packed = encoded;
        }
        return encoded;
    }
}
