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
 * Settings of the server.
 *
 * @param address port 0 selects a free port
 * @param limits on clients' messages and on stored data
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

    /** Returns the protocol's limits on 127.0.0.1. */
    public static AgentServerConfig onPort(int port) {
        return on(new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), port));
    }

    /** Returns the protocol's limits on a loopback address. */
    public static AgentServerConfig on(InetSocketAddress address) {
        return on(address, AgentSecurity.NONE);
    }

    /** Returns the protocol's limits on any address. */
    public static AgentServerConfig on(InetSocketAddress address, AgentSecurity security) {
        return new AgentServerConfig(
                address, AgentLimits.PROTOCOL, AgentTimeouts.PROTOCOL, Optional.empty(), security);
    }

    /** Returns a copy with an audit record. */
    public AgentServerConfig withAudit(AuditPlan plan) {
        return new AgentServerConfig(address, limits, timeouts, Optional.of(plan), security);
    }

    /** Returns a copy with another maximum deadline for agents in lock-step. */
    public AgentServerConfig withDeadline(Duration longest) {
        return with(longest, timeouts.waiting());
    }

    /**
     * Returns a copy with another allowance for delays by agents in lock-step; if empty, there is
     * no limit.
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
