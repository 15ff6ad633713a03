// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Arrays;
import java.util.Locale;
import java.util.Optional;

/**
 * The role of a client. It determines which messages the client may send, and what it perceives.
 */
public enum Role {
    /** A client that perceives and acts through a body. */
    AGENT,
    /**
     * A client that operates the world: it may pause the world, change its laws and edit it. It
     * perceives everything.
     */
    CONTROL,
    /** A client that perceives everything and cannot act. */
    OBSERVER;

    /** Returns the name of the role in the protocol. */
    public String wireName() {
        return name().toLowerCase(Locale.ROOT);
    }

    /** Finds a role by its name in the protocol. */
    public static Optional<Role> of(String wireName) {
        return Arrays.stream(values()).filter(role -> role.wireName().equals(wireName)).findFirst();
    }

    /** Returns all names, for messages. */
    public static String names() {
        return String.join(", ", Arrays.stream(values()).map(Role::wireName).toList());
    }
}
