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
 * Where the server listens and what it takes from a client.
 *
 * @param address port 0 takes any free one
 * @param limits how much it takes from clients, and keeps for them
 * @param timeouts how long it waits for them
 * @param audit where a record of all that clients are told is appended
 * @param security how clients and server know each other
 */
public record AgentServerConfig(
        InetSocketAddress address,
        AgentLimits limits,
        AgentTimeouts timeouts,
        Optional<AuditPlan> audit,
        AgentSecurity security) {

    /**
     * @throws IllegalArgumentException if other machines reach the address and there are no tokens
     *     or no TLS
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

    /** The protocol's limits on 127.0.0.1. */
    public static AgentServerConfig onPort(int port) {
        return on(new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), port));
    }

    /** The protocol's limits on a loopback address. */
    public static AgentServerConfig on(InetSocketAddress address) {
        return on(address, AgentSecurity.NONE);
    }

    /** The protocol's limits on any address. */
    public static AgentServerConfig on(InetSocketAddress address, AgentSecurity security) {
        return new AgentServerConfig(
                address, AgentLimits.PROTOCOL, AgentTimeouts.PROTOCOL, Optional.empty(), security);
    }

    /** The same, with a record of all that clients are told. */
    public AgentServerConfig withAudit(AuditPlan plan) {
        return new AgentServerConfig(address, limits, timeouts, Optional.of(plan), security);
    }

    /** The same, with another longest time that an agent in lock-step may have the world wait. */
    public AgentServerConfig withDeadline(Duration longest) {
        return with(longest, timeouts.waiting());
    }

    /**
     * The same, with another time that agents in lock-step may keep others waiting; without, there
     * is no limit.
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
