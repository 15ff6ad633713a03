// SPDX-License-Identifier: Apache-2.0
/**
 * Worlds as bytes: images, changes and digests, for stores and recordings. Depends on no engine,
 * file or database.
 */
@NullMarked
package reve.core.image;

import org.jspecify.annotations.NullMarked;
