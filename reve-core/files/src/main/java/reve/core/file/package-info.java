// SPDX-License-Identifier: Apache-2.0
/**
 * World files: YAML (or JSON) that a person writes. A file is checked completely, and every problem
 * is reported with line and column before a world is built. {@link WorldFile} is the entry point.
 */
@NullMarked
package reve.core.file;

import org.jspecify.annotations.NullMarked;
