// SPDX-License-Identifier: Apache-2.0
/** The few functions of the C library that Java lacks: memory that processes share. */
@NullMarked
package reve.pe.posix;

import org.jspecify.annotations.NullMarked;
