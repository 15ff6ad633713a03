// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.agent.audit.AuditPlan;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;

import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.time.Duration;
import java.util.Optional;

/**
 * Settings of the agent server.
 *
 * @param address address to listen on; port 0 selects a free port
 * @param limits limits on clients' messages and on the data stored for clients
 * @param timeouts time limits
 * @param audit settings of the audit record
 * @param security authentication and encryption
 */
public record AgentServerConfig(
        InetSocketAddress address,
        AgentLimits limits,
        AgentTimeouts timeouts,
        Optional<AuditPlan> audit,
        AgentSecurity security) {

    /**
     * Checks that a server is protected if other machines can reach it.
     *
     * @throws IllegalArgumentException if other machines can reach the address and there are no
     *     tokens or no TLS
     */
    public AgentServerConfig {
        if (address.isUnresolved()) {
            throw new IllegalArgumentException("there is no address of " + address.getHostString());
        }
        if (!address.getAddress().isLoopbackAddress() && !security.isComplete()) {
            throw new IllegalArgumentException(
                    "agents cannot be served on "
                            + address.getHostString()
                            + " without tokens and TLS: other machines reach it");
        }
    }

    /** Returns settings for the address 127.0.0.1, with the protocol's limits. */
    public static AgentServerConfig onPort(int port) {
        return on(new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), port));
    }

    /** Returns settings for a loopback address, with the protocol's limits. */
    public static AgentServerConfig on(InetSocketAddress address) {
        return on(address, AgentSecurity.NONE);
    }

    /** Returns settings for any address, with the protocol's limits. */
    public static AgentServerConfig on(InetSocketAddress address, AgentSecurity security) {
        return new AgentServerConfig(
                address, AgentLimits.PROTOCOL, AgentTimeouts.PROTOCOL, Optional.empty(), security);
    }

    /** Returns a copy with an audit record. */
    public AgentServerConfig withAudit(AuditPlan plan) {
        return new AgentServerConfig(address, limits, timeouts, Optional.of(plan), security);
    }

    /** Returns a copy with another maximum for the deadlines of agents in lock-step. */
    public AgentServerConfig withDeadline(Duration longest) {
        return with(longest, timeouts.waiting());
    }

    /**
     * Returns a copy with another limit on the time by which agents in lock-step may delay other
     * agents. An empty argument removes the limit.
     */
    public AgentServerConfig withWaiting(Optional<Duration> allowance) {
        return with(timeouts.deadline(), allowance);
    }

    private AgentServerConfig with(Duration deadline, Optional<Duration> waiting) {
        var other =
                new AgentTimeouts(
                        timeouts.hello(),
                        timeouts.line(),
                        timeouts.idle(),
                        timeouts.flood(),
                        timeouts.write(),
                        timeouts.grace(),
                        deadline,
                        waiting,
                        timeouts.linger());
        return new AgentServerConfig(address, limits, other, audit, security);
    }
}
