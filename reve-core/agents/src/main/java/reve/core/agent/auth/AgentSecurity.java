// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import java.util.Optional;

/**
 * How a server knows its clients, and they it.
 *
 * @param tokens who may come in, and with which rights; without, whoever can connect has all of
 *     them
 * @param tls what connections are kept private with; without, they are plain text
 */
public record AgentSecurity(Optional<TokenFile> tokens, Optional<ServerTls> tls) {

    /** For a loopback address, where all clients are this machine's own. */
    public static final AgentSecurity NONE = new AgentSecurity(Optional.empty(), Optional.empty());

    /** Whether it will do for an address that other machines reach. */
    public boolean isComplete() {
        return tokens.isPresent() && tls.isPresent();
    }
}
