// SPDX-License-Identifier: Apache-2.0
/** Files that a process writes, and the reasons why file operations fail. */
@NullMarked
package reve.core.disk;

import org.jspecify.annotations.NullMarked;
