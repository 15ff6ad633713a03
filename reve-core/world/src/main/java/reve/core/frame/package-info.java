// SPDX-License-Identifier: Apache-2.0
/** The frame, one tick of a world: its phases, its listeners, its commands, and when it runs. */
@NullMarked
package reve.core.frame;

import org.jspecify.annotations.NullMarked;
