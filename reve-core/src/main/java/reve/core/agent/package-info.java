/**
 * The TCP server that agents join: {@link AgentServer}. It serves protocol version 1 of
 * agents/protocol/PROTOCOL.md.
 *
 * <p>Threads: a reader and a writer (virtual) per connection, one publisher for all, and the
 * world's. Agents reach the world only through commands, which the frame loop's queue executes in
 * ACT, and see it only through snapshots, of which the publisher tells each what the sensors of its
 * body sense. On the world's thread this package neither waits nor touches a socket.
 */
@NullMarked
package reve.core.agent;

import org.jspecify.annotations.NullMarked;
