// SPDX-License-Identifier: Apache-2.0
/** Wiring: what makes a world file a running world, with or without agents and dropped laws. */
@NullMarked
package reve.worlds.server;

import org.jspecify.annotations.NullMarked;
