// SPDX-License-Identifier: Apache-2.0
/**
 * Commands of clients on their way to the world, and what operators do with worlds: images, saving,
 * forking.
 */
@NullMarked
package reve.core.agent.control;

import org.jspecify.annotations.NullMarked;
