// SPDX-License-Identifier: Apache-2.0
/** The application: entry point and version. */
@NullMarked
package reve.worlds;

import org.jspecify.annotations.NullMarked;
