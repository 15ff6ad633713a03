package reve.core.agent;

import java.util.Map;
import java.util.Optional;

/** What a client says. {@code id} is {@link #NO_ID} where it gave none. */
sealed interface ClientMessage {

    long NO_ID = -1;

    long id();

    /** @param body the lent item it asks for */
    record Hello(long id, int protocol, String name, String role, Optional<String> body) implements ClientMessage {}

    /** @param every frames between perceptions; 0 for no more, {@link #ONCE} for one now */
    record Perceive(long id, int every) implements ClientMessage {
        static final int ONCE = -1;
    }

    /** @param arguments Double, List of Double, String or Boolean by parameter name */
    record Act(long id, String item, String action, Map<String, Object> arguments) implements ClientMessage {}

    record Ping(long id) implements ClientMessage {}

    record Pong(long id) implements ClientMessage {}

    record Bye(long id) implements ClientMessage {}
}
