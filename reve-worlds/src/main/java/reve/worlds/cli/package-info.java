// SPDX-License-Identifier: Apache-2.0
/** The commands of {@code ./reve}: arguments in, results and exit codes out. */
@NullMarked
package reve.worlds.cli;

import org.jspecify.annotations.NullMarked;
