// SPDX-License-Identifier: Apache-2.0
/** A physics engine in a process of its own, which a faulty law can end without harm. */
@NullMarked
package reve.pe.hosted;

import org.jspecify.annotations.NullMarked;
