// SPDX-License-Identifier: Apache-2.0
/** Bindings of the C library functions for shared memory and child processes, which Java lacks. */
@NullMarked
package reve.pe.posix;

import org.jspecify.annotations.NullMarked;
