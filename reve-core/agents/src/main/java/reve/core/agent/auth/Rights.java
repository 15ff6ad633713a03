// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import reve.core.agent.protocol.Role;

import java.util.Optional;
import java.util.Set;

/**
 * The rights of a client. An empty Optional allows everything; a set allows only its elements.
 *
 * @param roles roles that the client may have
 * @param worlds names of the worlds that the client may join
 * @param bodies names of the items that the client may take as a body; if present, no new body is
 *     created for the client
 * @param capabilities capabilities of its body that the client may use
 * @param lockStep whether the client may run in lock-step
 */
public record Rights(
        Set<Role> roles,
        Optional<Set<String>> worlds,
        Optional<Set<String>> bodies,
        Optional<Set<String>> capabilities,
        boolean lockStep) {

    /** All rights, for clients of a server without tokens. */
    public static final Rights ALL =
            new Rights(
                    Set.of(Role.values()),
                    Optional.empty(),
                    Optional.empty(),
                    Optional.empty(),
                    true);

    /** Copies the sets. */
    public Rights {
        roles = Set.copyOf(roles);
        worlds = worlds.map(Set::copyOf);
        bodies = bodies.map(Set::copyOf);
        capabilities = capabilities.map(Set::copyOf);
    }

    /** Returns whether the client may join a world. */
    public boolean opensWorld(String name) {
        return worlds.isEmpty() || worlds.get().contains(name);
    }

    /** Returns whether the client may take an item as a body. */
    public boolean opensBody(String name) {
        return bodies.isEmpty() || bodies.get().contains(name);
    }

    /** Returns whether the client may use a capability of its body. */
    public boolean opensCapability(String name) {
        return capabilities.isEmpty() || capabilities.get().contains(name);
    }
}
