// SPDX-License-Identifier: Apache-2.0
/**
 * Worlds as bytes: images, changes and digests, for stores and recordings. Knows no engine, no file
 * and no database.
 */
@NullMarked
package reve.core.store;

import org.jspecify.annotations.NullMarked;
