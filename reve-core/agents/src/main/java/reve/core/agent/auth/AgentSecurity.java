// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import java.util.Optional;

/**
 * Authentication and encryption of a server.
 *
 * @param tokens file with the clients' tokens and their rights; if empty, every client that can
 *     connect has all rights
 * @param tls encryption of connections; if empty, connections are plain text
 */
public record AgentSecurity(Optional<TokenFile> tokens, Optional<ServerTls> tls) {

    /**
     * Settings without tokens and without TLS. They are permitted only for a loopback address,
     * which only clients on the same machine can reach.
     */
    public static final AgentSecurity NONE = new AgentSecurity(Optional.empty(), Optional.empty());

    /**
     * Returns whether there are both tokens and TLS. An address that other machines can reach
     * requires both.
     */
    public boolean isComplete() {
        return tokens.isPresent() && tls.isPresent();
    }
}
