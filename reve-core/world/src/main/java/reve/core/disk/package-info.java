// SPDX-License-Identifier: Apache-2.0
/** Files that a process writes during its whole run. */
@NullMarked
package reve.core.disk;

import org.jspecify.annotations.NullMarked;
