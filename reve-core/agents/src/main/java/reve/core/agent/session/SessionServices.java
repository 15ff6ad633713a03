// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.net.Counters;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;

/**
 * Services that the sessions of all worlds of a server share.
 *
 * @param log receives lines about clients that have sent hello
 * @param kept sessions without a token that wait for a new connection
 * @param wake makes the event loop look for work
 */
public record SessionServices(
        AgentLimits limits,
        AgentTimeouts timeouts,
        Counters counters,
        RateLimitedLog log,
        KeptSessions kept,
        Runnable wake) {}
