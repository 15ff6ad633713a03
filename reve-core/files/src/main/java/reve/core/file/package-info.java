// SPDX-License-Identifier: Apache-2.0
/**
 * World files, which are YAML (or JSON) that people write. A file is checked completely before a
 * world is built. Every problem is reported with line and column. {@link WorldFile} is the entry
 * point.
 */
@NullMarked
package reve.core.file;

import org.jspecify.annotations.NullMarked;
