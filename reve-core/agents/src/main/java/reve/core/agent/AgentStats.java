// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

/**
 * Counters since the start of the server.
 *
 * @param connections connections accepted so far
 * @param open connections open now
 * @param agents agents with a body now
 * @param joined agents that were admitted (sent a welcome) so far
 * @param lines messages received
 * @param errors messages refused with an error
 * @param perceptions perceptions queued for connections
 * @param actsAccepted acts that took effect
 * @param actsRefused acts that were refused
 * @param cut connections that the server ended because the client exceeded a limit
 * @param unrecorded messages sent without an audit record
 */
public record AgentStats(
        long connections,
        long open,
        long agents,
        long joined,
        long lines,
        long errors,
        long perceptions,
        long actsAccepted,
        long actsRefused,
        long cut,
        long unrecorded) {}
