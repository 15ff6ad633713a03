// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.time.Duration;
import java.util.Optional;

import javax.net.ssl.SSLContext;

/**
 * How to join a world: {@code Join.as("ada").withBody("boat")}.
 *
 * @param name 1 to 64 of A-Z a-z 0-9 _ . -
 * @param role "agent", "control" or "observer"
 * @param world that is joined; needed only where the server has several
 * @param body an item that the world lends to agents; empty to let the world choose
 * @param encoding how messages are written; MessagePack is faster and needs msgpack-core on the
 *     class path
 * @param grace how long the body may wait for the agent when the connection breaks
 * @param lockStep how the world waits for the agent; empty if it does not
 * @param resume the session to go on with
 * @param token for a server that asks for one
 * @param tls whom to trust on a private connection, see {@link Trust}; empty for plain text
 * @param patience longest wait for any answer
 */
public record Join(
        String name,
        String role,
        Optional<String> world,
        Optional<String> body,
        Encoding encoding,
        Duration grace,
        Optional<LockStep> lockStep,
        Optional<Resume> resume,
        Optional<String> token,
        Optional<SSLContext> tls,
        Duration patience) {

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
        return new Join(
                name,
                "agent",
                Optional.empty(),
                Optional.empty(),
                Encoding.JSON,
                Duration.ZERO,
                Optional.empty(),
                Optional.empty(),
                Optional.empty(),
                Optional.empty(),
                PATIENCE);
    }

    /** The same in another role. */
    public Join withRole(String newRole) {
        return new Join(
                name, newRole, world, body, encoding, grace, lockStep, resume, token, tls,
                patience);
    }

    /** The same, in the world of this name. */
    public Join withWorld(String newWorld) {
        return new Join(
                name,
                role,
                Optional.of(newWorld),
                body,
                encoding,
                grace,
                lockStep,
                resume,
                token,
                tls,
                patience);
    }

    /** The same, asking for this body. */
    public Join withBody(String item) {
        return new Join(
                name,
                role,
                world,
                Optional.of(item),
                encoding,
                grace,
                lockStep,
                resume,
                token,
                tls,
                patience);
    }

    /** The same in another encoding. */
    public Join withEncoding(Encoding newEncoding) {
        return new Join(
                name,
                role,
                world,
                body,
                newEncoding,
                grace,
                lockStep,
                resume,
                token,
                tls,
                patience);
    }

    /** The same; the session outlives a broken connection for so long. */
    public Join withGrace(Duration newGrace) {
        return new Join(
                name, role, world, body, encoding, newGrace, lockStep, resume, token, tls,
                patience);
    }

    /** The same, in lock-step with the world. */
    public Join withLockStep(LockStep time) {
        return new Join(
                name,
                role,
                world,
                body,
                encoding,
                grace,
                Optional.of(time),
                resume,
                token,
                tls,
                patience);
    }

    /** The same, resuming a session. */
    public Join withResume(Resume session) {
        return new Join(
                name,
                role,
                world,
                body,
                encoding,
                grace,
                lockStep,
                Optional.of(session),
                token,
                tls,
                patience);
    }

    /** The same, with the secret of a token. */
    public Join withToken(String secret) {
        return new Join(
                name,
                role,
                world,
                body,
                encoding,
                grace,
                lockStep,
                resume,
                Optional.of(secret),
                tls,
                patience);
    }

    /** The same, over TLS that trusts this context's certificates. */
    public Join withTls(SSLContext trusted) {
        return new Join(
                name,
                role,
                world,
                body,
                encoding,
                grace,
                lockStep,
                resume,
                token,
                Optional.of(trusted),
                patience);
    }

    /** The same, waiting for the server at most so long. */
    public Join withPatience(Duration newPatience) {
        return new Join(
                name,
                role,
                world,
                body,
                encoding,
                grace,
                lockStep,
                resume,
                token,
                tls,
                newPatience);
    }

    /** How another connection goes on with a session that this one began. */
    Join resuming(String inWorld, Resume session) {
        return new Join(
                name,
                role,
                Optional.of(inWorld),
                Optional.empty(),
                encoding,
                Duration.ZERO,
                Optional.empty(),
                Optional.of(session),
                token,
                tls,
                patience);
    }

    /** Without its secrets. */
    @Override
    public String toString() {
        return role + " " + name;
    }
}
