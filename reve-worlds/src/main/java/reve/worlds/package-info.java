// SPDX-License-Identifier: Apache-2.0
/** The application: its entry point and its version. */
@NullMarked
package reve.worlds;

import org.jspecify.annotations.NullMarked;
