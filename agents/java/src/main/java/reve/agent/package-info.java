// SPDX-License-Identifier: Apache-2.0
/**
 * Agents in Java: {@link reve.agent.AgentClient} joins a REVE world over TCP, perceives and acts.
 * It needs Jackson and nothing of the server. The protocol is described in
 * agents/protocol/PROTOCOL.md.
 */
@NullMarked
package reve.agent;

import org.jspecify.annotations.NullMarked;
