// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Arrays;
import java.util.Locale;
import java.util.Optional;

/** What a client is to the world. */
public enum Role {
    /** Perceives and acts through a body. */
    AGENT,
    /** Runs the world: pauses it, changes its laws, edits it. Perceives everything. */
    CONTROL,
    /** Perceives everything and does nothing. */
    OBSERVER;

    /** As the protocol writes it. */
    public String wireName() {
        return name().toLowerCase(Locale.ROOT);
    }

    /** Finds a role by the name that the protocol writes. */
    public static Optional<Role> of(String wireName) {
        return Arrays.stream(values()).filter(role -> role.wireName().equals(wireName)).findFirst();
    }

    /** Returns all names, for messages. */
    public static String names() {
        return String.join(", ", Arrays.stream(values()).map(Role::wireName).toList());
    }
}
