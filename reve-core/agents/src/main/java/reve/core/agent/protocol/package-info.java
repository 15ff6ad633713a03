// SPDX-License-Identifier: Apache-2.0
/**
 * Messages of the agent protocol, version 1 (agents/protocol/PROTOCOL.md): parsing, encoding and
 * limits. Depends on no socket and no world.
 */
@NullMarked
package reve.core.agent.protocol;

import org.jspecify.annotations.NullMarked;
