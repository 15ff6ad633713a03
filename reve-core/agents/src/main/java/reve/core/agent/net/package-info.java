// SPDX-License-Identifier: Apache-2.0
/**
 * Connections: sockets, TLS, framing of messages, outbound queues, and the event loop that serves
 * them. The package does not depend on worlds. It uses the session of a connection through the
 * interface {@link reve.core.agent.net.Client}.
 */
@NullMarked
package reve.core.agent.net;

import org.jspecify.annotations.NullMarked;
