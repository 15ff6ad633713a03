// SPDX-License-Identifier: Apache-2.0
/** Bindings of the C library functions for memory that processes share, which Java lacks. */
@NullMarked
package reve.pe.posix;

import org.jspecify.annotations.NullMarked;
