// SPDX-License-Identifier: Apache-2.0
/**
 * World files: YAML (or JSON) that a person writes, checked as a whole, with every problem reported
 * at its line and column before anything is built. {@link WorldFile} is the way in.
 */
@NullMarked
package reve.core.file;

import org.jspecify.annotations.NullMarked;
