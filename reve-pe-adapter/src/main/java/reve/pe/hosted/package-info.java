// SPDX-License-Identifier: Apache-2.0
/**
 * A physics engine in its own process. So a faulty law can end only this process, and not the
 * server.
 */
@NullMarked
package reve.pe.hosted;

import org.jspecify.annotations.NullMarked;
