// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Arrays;
import java.util.Locale;
import java.util.Optional;

/** The role of a client, which determines what it may do. */
public enum Role {
    /** Perceives and acts through a body. */
    AGENT,
    /** Operates the world: pauses it, changes its laws, edits it. Perceives everything. */
    CONTROL,
    /** Perceives everything and cannot act. */
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
