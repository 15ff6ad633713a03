// SPDX-License-Identifier: Apache-2.0
/**
 * Sessions of clients, from the hello until they leave, across broken connections; and the hosted
 * worlds.
 */
@NullMarked
package reve.core.agent.session;

import org.jspecify.annotations.NullMarked;
