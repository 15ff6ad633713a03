package reve.agent;

import java.time.Duration;
import java.util.Optional;

/**
 * How to join a world: {@code Join.as("ada").withBody("boat")}.
 *
 * @param name 1 to 64 of A-Z a-z 0-9 _ . -
 * @param role "agent", "control" or "observer"
 * @param body an item that the world lends to agents; empty to let the world choose
 * @param encoding how messages are written; MessagePack is faster and needs msgpack-core on the class path
 * @param grace how long the body may wait for the agent when the connection breaks
 * @param resume the session to go on with
 * @param patience longest wait for any answer
 */
public record Join(String name, String role, Optional<String> body, Encoding encoding, Duration grace,
        Optional<Resume> resume, Duration patience) {

    private static final Duration PATIENCE = Duration.ofSeconds(10);

    /**
     * A session whose connection broke.
     *
     * @param session the token that its welcome gave
     * @param frame the last one whose events have all come
     */
    public record Resume(String session, long frame) {}

    /** As an agent with a body that the world chooses. */
    public static Join as(String name) {
        return new Join(name, "agent", Optional.empty(), Encoding.JSON, Duration.ZERO, Optional.empty(), PATIENCE);
    }

    public Join withRole(String newRole) {
        return new Join(name, newRole, body, encoding, grace, resume, patience);
    }

    public Join withBody(String item) {
        return new Join(name, role, Optional.of(item), encoding, grace, resume, patience);
    }

    public Join withEncoding(Encoding newEncoding) {
        return new Join(name, role, body, newEncoding, grace, resume, patience);
    }

    public Join withGrace(Duration newGrace) {
        return new Join(name, role, body, encoding, newGrace, resume, patience);
    }

    public Join withResume(Resume session) {
        return new Join(name, role, body, encoding, grace, Optional.of(session), patience);
    }

    public Join withPatience(Duration newPatience) {
        return new Join(name, role, body, encoding, grace, resume, newPatience);
    }
}
