// SPDX-License-Identifier: Apache-2.0
/**
 * Connections: sockets, TLS, framing of messages, outbound queues, and the event loop that serves
 * them. The package knows no world; the session behind a connection is a {@link
 * reve.core.agent.net.Client}.
 */
@NullMarked
package reve.core.agent.net;

import org.jspecify.annotations.NullMarked;
