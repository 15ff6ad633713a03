// SPDX-License-Identifier: Apache-2.0
/**
 * The TCP server that agents join: {@link AgentServer}. It serves protocol version 1 of
 * agents/protocol/PROTOCOL.md.
 *
 * <p>Threads: one event loop reads and writes for all clients and tells each what the sensors of
 * its body sense; beside it runs each world's own. Agents reach a world only through commands,
 * which the frame loop's queue executes in ACT, and see it only through snapshots. A world that
 * goes as fast as it can runs the event loop itself while it waits for agents in lock-step;
 * otherwise its thread touches no socket.
 */
@NullMarked
package reve.core.agent;

import org.jspecify.annotations.NullMarked;
