/**
 * The TCP server that agents join: {@link AgentServer}. It serves protocol version 1 of
 * agents/protocol/PROTOCOL.md.
 *
 * <p>Threads: a reader and a writer (virtual) per connection, one publisher for all, and the world's. Agents
 * reach the world only through commands, which the frame loop's queue executes in ACT, and see it only through
 * snapshots, which the publisher encodes once for everybody. On the world's thread this package neither waits
 * nor touches a socket.
 */
@NullMarked
package reve.core.agent;

import org.jspecify.annotations.NullMarked;
