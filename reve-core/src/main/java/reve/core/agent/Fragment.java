package reve.core.agent;

import java.util.function.Consumer;
import org.jspecify.annotations.Nullable;

/** A value that is encoded once, when first needed, for all messages that hold it. One thread. */
final class Fragment {

    private final Consumer<MessageWriter> content;
    private byte @Nullable [] json;
    private byte @Nullable [] packed;

    Fragment(Consumer<MessageWriter> content) {
        this.content = content;
    }

    /** The caller does not change the bytes. */
    byte[] in(Encoding encoding) {
        byte[] known = encoding == Encoding.JSON ? json : packed;
        if (known == null) {
            known = encoding.value(content);
            if (encoding == Encoding.JSON) {
                json = known;
            } else {
                packed = known;
            }
        }
        return known;
    }
}
