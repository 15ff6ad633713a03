// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

/**
 * Counters since the server started.
 *
 * @param connections accepted so far
 * @param open connections now
 * @param agents with a body now
 * @param joined agents welcomed so far
 * @param lines received
 * @param errors lines refused with an error
 * @param perceptions handed to connections
 * @param actsAccepted acts that took effect
 * @param actsRefused acts that did not
 * @param cut connections that the server ended for breaking a limit
 * @param unrecorded messages sent without the record that was asked for
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
