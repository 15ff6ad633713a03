// SPDX-License-Identifier: Apache-2.0
/** Files for other programs, made from the frames of a run: tables in CSV, and MCAP. */
@NullMarked
package reve.worlds.export;

import org.jspecify.annotations.NullMarked;
