package reve.core.agent;

import java.nio.charset.StandardCharsets;
import java.util.function.Consumer;
import org.jspecify.annotations.Nullable;
import tools.jackson.core.io.SerializedString;

/** A value that is encoded once, when first needed, for all messages that hold it. One thread. */
final class Fragment {

    private final Consumer<MessageWriter> content;
    private @Nullable SerializedString json;
    private byte @Nullable [] packed;

    Fragment(Consumer<MessageWriter> content) {
        this.content = content;
    }

    SerializedString json() {
        SerializedString known = json;
        if (known == null) {
            known = new SerializedString(new String(Encoding.JSON.value(content), StandardCharsets.UTF_8));
            json = known;
        }
        return known;
    }

    /** As MessagePack; the caller does not change the bytes. */
    byte[] packed() {
        byte[] known = packed;
        if (known == null) {
            known = Encoding.MESSAGEPACK.value(content);
            packed = known;
        }
        return known;
    }
}
