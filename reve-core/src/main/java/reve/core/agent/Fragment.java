// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import org.jspecify.annotations.Nullable;

import java.util.function.Consumer;

/**
 * A value that is encoded when first needed, for all messages that hold it. Threads that need it at
 * the same time encode the same bytes.
 */
final class Fragment {

    private final Consumer<MessageWriter> content;
    private volatile byte @Nullable [] json;
    private volatile byte @Nullable [] packed;

    Fragment(Consumer<MessageWriter> content) {
        this.content = content;
    }

    /** The caller does not change the bytes. */
    byte[] in(Encoding encoding) {
        byte[] known = known(encoding);
        return known != null ? known : keep(encoding, encoding.value(content));
    }

    /** Writes the value where the writer is. @param out what the writer writes to */
    void write(MessageWriter writer, Bytes out) {
        Encoding encoding = writer.encoding();
        byte[] known = known(encoding);
        if (known != null) {
            out.put(known);
        } else {
            int start = out.size();
            content.accept(writer);
            keep(encoding, out.copy(start));
        }
    }

    private byte @Nullable [] known(Encoding encoding) {
        return encoding == Encoding.JSON ? json : packed;
    }

    private byte[] keep(Encoding encoding, byte[] encoded) {
        if (encoding == Encoding.JSON) {
            json = encoded;
        } else {
            packed = encoded;
        }
        return encoded;
    }
}
