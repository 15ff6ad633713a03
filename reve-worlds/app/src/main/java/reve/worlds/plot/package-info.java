// SPDX-License-Identifier: Apache-2.0
/** Charts as PNG files. */
@NullMarked
package reve.worlds.plot;

import org.jspecify.annotations.NullMarked;
