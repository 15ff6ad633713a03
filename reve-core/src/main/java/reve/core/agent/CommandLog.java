package reve.core.agent;

import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * Which commands a client has given, by their ids, so that one sent twice is done once. Of the last
 * {@value #REMEMBERED} it knows the result; an id that could be older is not taken. Guarded by its session.
 */
final class CommandLog {

    static final int REMEMBERED = 1024;

    private final Map<Long, Optional<ServerMessage>> results = new LinkedHashMap<>();
    private long highestForgotten = -1;

    /** What is known of an id. */
    sealed interface Known {

        /** It has not been seen. */
        record Fresh() implements Known {}

        /** The result will come. */
        record Pending() implements Known {}

        record Done(ServerMessage result) implements Known {}

        /** It may have been done; nobody remembers. */
        record Forgotten() implements Known {}
    }

    Known look(long id) {
        Optional<ServerMessage> result = results.get(id);
        if (result == null) {
            return id > highestForgotten ? new Known.Fresh() : new Known.Forgotten();
        }
        return result.isPresent() ? new Known.Done(result.get()) : new Known.Pending();
    }

    /** The command was taken. */
    void begin(long id) {
        results.put(id, Optional.empty());
    }

    /** The command was not taken after all, and may be sent again. */
    void cancel(long id) {
        results.remove(id);
    }

    void finish(long id, ServerMessage result) {
        results.remove(id); // so that the order is that of finishing
        results.put(id, Optional.of(result));
        var oldest = results.entrySet().iterator();
        while (results.size() > REMEMBERED && oldest.hasNext()) {
            var entry = oldest.next();
            if (entry.getValue().isPresent()) {
                highestForgotten = Math.max(highestForgotten, entry.getKey());
                oldest.remove();
            }
        }
    }
}
