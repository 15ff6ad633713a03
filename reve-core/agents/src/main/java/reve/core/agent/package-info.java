// SPDX-License-Identifier: Apache-2.0
/**
 * The TCP server for agents: {@link AgentServer}. It implements protocol version 1 of
 * agents/protocol/PROTOCOL.md.
 *
 * <p>One event loop reads and writes for all clients. It sends each client data about the items
 * that the sensors of its body reach. Each world has its own thread. Agents change a world only
 * through commands: the frame loop takes them from a queue and executes them in the phase ACT.
 * Agents perceive a world only through snapshots. The server may host a single world without a
 * fixed rate. The world's thread then runs the event loop while it waits for agents in lock-step. A
 * world's thread never uses sockets otherwise.
 */
@NullMarked
package reve.core.agent;

import org.jspecify.annotations.NullMarked;
