// SPDX-License-Identifier: Apache-2.0
/**
 * Clients from their hello until they leave, across broken connections, and the worlds that they
 * are in.
 */
@NullMarked
package reve.core.agent.session;

import org.jspecify.annotations.NullMarked;
