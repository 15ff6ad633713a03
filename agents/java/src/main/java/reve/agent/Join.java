// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.time.Duration;
import java.util.Optional;

import javax.net.ssl.SSLContext;

/**
 * Settings of a session: {@code Join.as("ada").withBody("boat")}.
 *
 * @param name 1 to 64 characters of A-Z a-z 0-9 _ . -
 * @param role "agent", "control" or "observer"
 * @param world name of the world; needed only if the server has several
 * @param body an item that the world grants to agents; empty to let the world choose
 * @param encoding encoding of messages; MessagePack is faster than JSON and needs msgpack-core on
 *     the class path
 * @param grace time that the body waits for the agent after the connection breaks
 * @param lockStep settings of lock-step; empty for real time
 * @param resume the session to resume
 * @param token the secret, if the server requires one
 * @param tls TLS trust anchors, see {@link Trust}; empty for plain text
 * @param patience maximum wait for any answer
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
     * @param session token from the welcome
     * @param frame the last frame whose events were all received
     */
    public record Resume(String session, long frame) {}

    /** Returns settings of an agent with a body that the world chooses. */
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

    /** Returns a copy with another role. */
    public Join withRole(String newRole) {
        return new Join(
                name, newRole, world, body, encoding, grace, lockStep, resume, token, tls,
                patience);
    }

    /** Returns a copy for the world of this name. */
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

    /** Returns a copy that requests this body. */
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

    /** Returns a copy with another encoding. */
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

    /** Returns a copy whose session outlives a broken connection for this time. */
    public Join withGrace(Duration newGrace) {
        return new Join(
                name, role, world, body, encoding, newGrace, lockStep, resume, token, tls,
                patience);
    }

    /** Returns a copy in lock-step with the world. */
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

    /** Returns a copy that resumes a session. */
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

    /** Returns a copy with the secret of a token. */
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

    /** Returns a copy that uses TLS and trusts this context's certificates. */
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

    /** Returns a copy with another maximum wait for the server. */
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

    /** Returns the settings that resume a session of this join. */
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

    /** Returns the settings without the secrets. */
    @Override
    public String toString() {
        return role + " " + name;
    }
}
