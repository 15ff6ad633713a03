// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.protocol.ServerMessage;

/**
 * The part of an agent's utterance that one other agent hears. Immutable.
 *
 * @param hearer name of the agent that hears it
 * @param event the event {@code heard} that is sent to this agent only
 */
public record Heard(String hearer, ServerMessage.Event event) {}
