// SPDX-License-Identifier: Apache-2.0
/**
 * A physics engine in a process of its own, so that a faulty law can end this process only, and not
 * the server.
 */
@NullMarked
package reve.pe.hosted;

import org.jspecify.annotations.NullMarked;
