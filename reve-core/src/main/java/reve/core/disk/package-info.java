// SPDX-License-Identifier: Apache-2.0
/** Files that a process writes for as long as it runs. */
@NullMarked
package reve.core.disk;

import org.jspecify.annotations.NullMarked;
