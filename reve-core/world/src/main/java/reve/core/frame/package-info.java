// SPDX-License-Identifier: Apache-2.0
/** The frame: its phases, its listeners, its commands, and its pacing. */
@NullMarked
package reve.core.frame;

import org.jspecify.annotations.NullMarked;
