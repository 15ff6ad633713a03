// SPDX-License-Identifier: Apache-2.0
/**
 * Connections: sockets, TLS, cutting bytes into messages, queues of what is to be written, and the
 * event loop that serves them. Knows no world; who is behind a connection is a Client.
 */
@NullMarked
package reve.core.agent.net;

import org.jspecify.annotations.NullMarked;
