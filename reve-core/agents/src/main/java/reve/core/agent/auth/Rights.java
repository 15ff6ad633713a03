// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import reve.core.agent.protocol.Role;

import java.util.Optional;
import java.util.Set;

/**
 * What a client may be and do. Whatever is not named here is refused, but for what is empty: an
 * absent set does not restrict.
 *
 * @param roles that it may join in
 * @param worlds that it may join, by name
 * @param bodies the lent items that it may have as a body; with them, no body is made for it
 * @param capabilities those of its body that it may use
 * @param lockStep whether it may have the world wait for it
 */
public record Rights(
        Set<Role> roles,
        Optional<Set<String>> worlds,
        Optional<Set<String>> bodies,
        Optional<Set<String>> capabilities,
        boolean lockStep) {

    /** All there are: of whoever can connect to a server without tokens. */
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

    /** Returns true if a world may be joined. */
    public boolean opensWorld(String name) {
        return worlds.isEmpty() || worlds.get().contains(name);
    }

    /** Returns true if a lent item may be had as a body. */
    public boolean opensBody(String name) {
        return bodies.isEmpty() || bodies.get().contains(name);
    }

    /** Returns true if a capability of the body may be used. */
    public boolean opensCapability(String name) {
        return capabilities.isEmpty() || capabilities.get().contains(name);
    }
}
