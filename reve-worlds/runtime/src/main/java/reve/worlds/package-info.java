// SPDX-License-Identifier: Apache-2.0
/** The name and version of the product. */
@NullMarked
package reve.worlds;

import org.jspecify.annotations.NullMarked;
