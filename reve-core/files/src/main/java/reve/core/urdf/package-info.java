// SPDX-License-Identifier: Apache-2.0
/**
 * Import of robot models. It contains readers of URDF and MJCF files, and a writer of world files
 * from their content. An imported world needs nothing of this package.
 */
@NullMarked
package reve.core.urdf;

import org.jspecify.annotations.NullMarked;
