// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.Text;

import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.security.SecureRandom;
import java.time.Instant;
import java.util.HexFormat;
import java.util.Optional;

/**
 * A token of a client as the server stores it. The server stores the SHA-256 of the secret, not the
 * secret. Salts and slow hashes are not needed, because the secret has 128 random bits and cannot
 * be guessed.
 *
 * @param name name that the client must have
 * @param sha256 SHA-256 of the secret's text, in hexadecimal
 * @param rights rights of the client
 * @param expires time when the token becomes invalid; never if empty
 */
public record AgentToken(String name, String sha256, Rights rights, Optional<Instant> expires) {

    private static final SecureRandom RANDOM = new SecureRandom();
    private static final int SECRET_BYTES = 16;
    private static final int ID_LENGTH = 8;

    /**
     * Checks the fields.
     *
     * @throws IllegalArgumentException naming the invalid field
     */
    public AgentToken {
        if (!ClientMessage.Hello.isName(name)) {
            throw new IllegalArgumentException(
                    Text.quote(name)
                            + " is no name for a client; expected 1 to 64 of A-Z a-z"
                            + " 0-9 _ . -, beginning with a letter or digit");
        }
        if (!sha256.matches("[0-9a-f]{64}")) {
            throw new IllegalArgumentException(
                    "sha256 of the token of " + name + " is not 64 hexadecimal digits");
        }
        if (rights.roles().isEmpty()) {
            throw new IllegalArgumentException(
                    "the token of " + name + " has no role; expected some of " + Role.names());
        }
    }

    /** Creates a token with a new secret. */
    public static Issued issue(String name, Rights rights, Optional<Instant> expires) {
        String secret = newSecret();
        return new Issued(secret, new AgentToken(name, hash(secret), rights, expires));
    }

    /**
     * A new token, with its secret.
     *
     * @param secret the secret for the client, which the server does not store
     */
    public record Issued(String secret, AgentToken token) {
        @Override
        public String toString() {
            return token.toString();
        }
    }

    /** Returns a new secret: 128 random bits in hexadecimal. */
    public static String newSecret() {
        byte[] bytes = new byte[SECRET_BYTES];
        RANDOM.nextBytes(bytes);
        return HexFormat.of().formatHex(bytes);
    }

    /** Returns the SHA-256 of a secret's text, in hexadecimal. */
    public static String hash(String secret) {
        try {
            return HexFormat.of()
                    .formatHex(
                            MessageDigest.getInstance("SHA-256")
                                    .digest(secret.getBytes(StandardCharsets.UTF_8)));
        } catch (NoSuchAlgorithmException e) {
            throw new IllegalStateException("every Java runtime has SHA-256", e);
        }
    }

    /** Returns an id of the token for operators, which reveals nothing about the secret. */
    public String id() {
        return sha256.substring(0, ID_LENGTH);
    }

    /** Returns whether the token has expired; true from the moment of expiry. */
    public boolean hasExpired(Instant now) {
        return expires.isPresent() && !now.isBefore(expires.get());
    }
}
