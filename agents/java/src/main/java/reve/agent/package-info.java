// SPDX-License-Identifier: Apache-2.0
/**
 * Client library for agents in Java: {@link reve.agent.AgentClient} joins a REVE world over TCP,
 * perceives and acts. It depends on Jackson and on no code of the server. The protocol is described
 * in agents/protocol/PROTOCOL.md.
 */
@NullMarked
package reve.agent;

import org.jspecify.annotations.NullMarked;
