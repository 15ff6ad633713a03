// SPDX-License-Identifier: Apache-2.0
/**
 * Wiring: builds a running world from a world file, with or without agents and a watched laws
 * folder.
 */
@NullMarked
package reve.worlds.server;

import org.jspecify.annotations.NullMarked;
