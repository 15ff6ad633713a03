// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Role;

import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;

/**
 * The rights of a client. An empty Optional allows everything; a set allows only its elements.
 *
 * @param roles roles that the client may have
 * @param worlds names of the worlds that the client may join
 * @param bodies names of the items that the client may take as a body; if present, no new body is
 *     created for the client
 * @param capabilities capabilities of its body that the client may use
 * @param lockStep whether the client may run in lock-step
 * @param laws laws that a client with the role control may change. An element is the name of a
 *     library, or {@code LIBRARY.PARAMETER} for a single parameter. If present, the client may
 *     change nothing else.
 */
public record Rights(
        Set<Role> roles,
        Optional<Set<String>> worlds,
        Optional<Set<String>> bodies,
        Optional<Set<String>> capabilities,
        boolean lockStep,
        Optional<Set<String>> laws) {

    /** All rights, for clients of a server without tokens. */
    public static final Rights ALL =
            new Rights(
                    Set.of(Role.values()),
                    Optional.empty(),
                    Optional.empty(),
                    Optional.empty(),
                    true,
                    Optional.empty());

    /** Copies the sets. */
    public Rights {
        roles = Set.copyOf(roles);
        worlds = worlds.map(Set::copyOf);
        bodies = bodies.map(Set::copyOf);
        capabilities = capabilities.map(Set::copyOf);
        laws = laws.map(Set::copyOf);
    }

    /** Creates rights that do not limit the role control. */
    public Rights(
            Set<Role> roles,
            Optional<Set<String>> worlds,
            Optional<Set<String>> bodies,
            Optional<Set<String>> capabilities,
            boolean lockStep) {
        this(roles, worlds, bodies, capabilities, lockStep, Optional.empty());
    }

    /** Returns whether the client may load, replace and unload a library of laws. */
    public boolean opensLaw(String library) {
        return laws.isEmpty() || laws.get().contains(library);
    }

    /**
     * Returns why the client may not send a command of the role control; empty if it may. For
     * {@code load-law} this method does not check the library, because its name is known only after
     * the library was opened. See {@link #opensLaw}.
     */
    public Optional<String> refusal(ClientMessage.Request request) {
        if (worlds.isPresent() && request instanceof ClientMessage.Order) {
            return Optional.of("it opens only some worlds, and the order is about all worlds");
        }
        if (worlds.isPresent()
                && request instanceof ClientMessage.Ask ask
                && ask.what().equals("cluster")) {
            return Optional.of("it opens only some worlds, and the answer is about all worlds");
        }
        if (laws.isEmpty()) {
            return Optional.empty();
        }
        return switch (request) {
            case ClientMessage.Act _, ClientMessage.Query _ -> Optional.empty();
            case ClientMessage.Ask _, ClientMessage.LoadLaw _ -> Optional.empty();
            case ClientMessage.Ledger ledger when ledger.open().isEmpty() -> Optional.empty();
            case ClientMessage.UnloadLaw unload -> refusalOfLaw(unload.library());
            case ClientMessage.SetBudget set -> refusalOfLaw(set.library());
            case ClientMessage.Release release -> refusalOfLaw(release.library());
            case ClientMessage.SetLaw set -> refusalOfParameters(set);
            default -> Optional.of("it may change only " + shownLaws());
        };
    }

    /** Returns why the client may not change a library; empty if it may. */
    public Optional<String> refusalOfLaw(String library) {
        return opensLaw(library)
                ? Optional.empty()
                : Optional.of("it may change only " + shownLaws() + ", not " + library);
    }

    private Optional<String> refusalOfParameters(ClientMessage.SetLaw set) {
        if (opensLaw(set.library())) {
            return Optional.empty();
        }
        String prefix = set.library() + ".";
        for (String parameter : set.parameters().keySet()) {
            String full = parameter.startsWith(prefix) ? parameter : prefix + parameter;
            if (!opensLaw(full)) {
                return refusalOfLaw(full);
            }
        }
        return set.parameters().isEmpty() ? refusalOfLaw(set.library()) : Optional.empty();
    }

    private String shownLaws() {
        return laws.orElseThrow().isEmpty()
                ? "no law"
                : "the laws " + String.join(", ", new TreeSet<>(laws.get()));
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
