// SPDX-License-Identifier: Apache-2.0
/** The frame: its phases, who takes part in them, and how fast they follow each other. */
@NullMarked
package reve.core.frame;

import org.jspecify.annotations.NullMarked;
