// SPDX-License-Identifier: Apache-2.0
/**
 * A physics engine in its own process. A faulty law can therefore end only this process, and not
 * the server.
 */
@NullMarked
package reve.pe.hosted;

import org.jspecify.annotations.NullMarked;
