// SPDX-License-Identifier: Apache-2.0
/**
 * Encoding of worlds as bytes for store files and recordings: images (complete states), changes and
 * digests. This package depends on no engine, file or database.
 */
@NullMarked
package reve.core.image;

import org.jspecify.annotations.NullMarked;
