// SPDX-License-Identifier: Apache-2.0
/**
 * The TCP server for agents: {@link AgentServer}. It implements protocol version 1 of
 * agents/protocol/PROTOCOL.md.
 *
 * <p>Threads: one event loop reads and writes for all clients, and sends each client the data that
 * the sensors of its body reach; each world has its own thread. Agents change a world only through
 * commands, which the frame loop takes from a queue and executes in the phase ACT, and perceive it
 * only through snapshots. The thread of a world without a fixed rate runs the event loop while it
 * waits for agents in lock-step; no other thread of a world uses sockets.
 */
@NullMarked
package reve.core.agent;

import org.jspecify.annotations.NullMarked;
