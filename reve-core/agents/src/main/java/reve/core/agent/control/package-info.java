// SPDX-License-Identifier: Apache-2.0
/** Commands of clients to the world, and operators' work with worlds: images, saving, forking. */
@NullMarked
package reve.core.agent.control;

import org.jspecify.annotations.NullMarked;
