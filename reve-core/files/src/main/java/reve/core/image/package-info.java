// SPDX-License-Identifier: Apache-2.0
/**
 * Encoding of worlds as bytes: images (complete states), changes and digests, for store files and
 * recordings. Depends on no engine, file or database.
 */
@NullMarked
package reve.core.image;

import org.jspecify.annotations.NullMarked;
