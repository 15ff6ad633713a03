// SPDX-License-Identifier: Apache-2.0
/**
 * The messages of the agent protocol, version 1 of agents/protocol/PROTOCOL.md: reading, writing
 * and limits. Knows no socket and no world.
 */
@NullMarked
package reve.core.agent.protocol;

import org.jspecify.annotations.NullMarked;
