// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.net.Counters;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;

import java.util.List;
import java.util.Optional;
import java.util.function.BooleanSupplier;
import java.util.function.Supplier;

/**
 * Services that the sessions of all worlds of a server share.
 *
 * @param log receives lines about clients that have sent hello
 * @param kept sessions without a token that wait for a new connection
 * @param wake makes the event loop look for work
 * @param audit the record of all messages to clients
 * @param servers returns the addresses of other servers that may continue sessions
 * @param isShared returns whether the server has several worlds
 */
public record SessionServices(
        AgentLimits limits,
        AgentTimeouts timeouts,
        Counters counters,
        RateLimitedLog log,
        KeptSessions kept,
        Runnable wake,
        Optional<AuditLog> audit,
        Supplier<List<String>> servers,
        BooleanSupplier isShared) {}
