// SPDX-License-Identifier: Apache-2.0
/**
 * The sessions of clients, from the hello until the client leaves, including the time in which a
 * connection is broken. Also the worlds that the server hosts.
 */
@NullMarked
package reve.core.agent.session;

import org.jspecify.annotations.NullMarked;
