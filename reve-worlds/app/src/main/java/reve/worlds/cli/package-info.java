// SPDX-License-Identifier: Apache-2.0
/** The commands of {@code ./reve}. They parse options, print results and return exit codes. */
@NullMarked
package reve.worlds.cli;

import org.jspecify.annotations.NullMarked;
