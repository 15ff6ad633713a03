package reve.core.agent;

import java.util.EnumMap;
import java.util.IdentityHashMap;
import java.util.Map;
import org.jspecify.annotations.Nullable;

/** Encodes what agents are told of a frame; what several are told alike is encoded once. The event loop's thread. */
final class Telling {

    private final Map<View, Map<Encoding, View.Told>> since = new IdentityHashMap<>();
    private final Bytes scratch = new Bytes();
    private @Nullable View shared;

    /** A frame begins. @param everything what all agents without sensors perceive */
    void begin(View everything) {
        since.clear();
        shared = everything;
    }

    View.Told whole(View view, Encoding encoding) {
        return view == shared ? of(view).computeIfAbsent(encoding, e -> view.whole(e, scratch))
                : view.whole(encoding, scratch);
    }

    View.Told since(View before, View now, Encoding encoding) {
        return now == shared ? of(before).computeIfAbsent(encoding, e -> now.since(before, e, scratch))
                : now.since(before, encoding, scratch);
    }

    /** The beginning of a perception. */
    byte[] head(Encoding encoding, long id, View.Told told) {
        return encoding.head(scratch, "perception", id, told.fields(), told.bytes().length);
    }

    /** The whole of the shared view is kept under the view itself, a difference under what it is to. */
    private Map<Encoding, View.Told> of(View view) {
        return since.computeIfAbsent(view, unknown -> new EnumMap<>(Encoding.class));
    }
}
