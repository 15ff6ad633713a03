// SPDX-License-Identifier: Apache-2.0
/**
 * The sessions of clients, from the hello until the client leaves, also across broken connections;
 * and the worlds that the server hosts.
 */
@NullMarked
package reve.core.agent.session;

import org.jspecify.annotations.NullMarked;
