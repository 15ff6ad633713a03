// SPDX-License-Identifier: Apache-2.0
/**
 * Import of robot models: the readers of URDF and MJCF files, and the writer of world files from
 * them. A world that was imported needs nothing of this package.
 */
@NullMarked
package reve.core.urdf;

import org.jspecify.annotations.NullMarked;
