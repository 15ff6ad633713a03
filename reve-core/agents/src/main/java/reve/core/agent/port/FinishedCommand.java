// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

/**
 * The result of a command of a client.
 *
 * @param id the client's number of the command
 * @param frame frame in which the command took effect; 0 if it was refused
 * @param code code of the refusal; empty if the command was accepted
 * @param reason reason of the refusal; empty if the command was accepted
 */
public record FinishedCommand(long id, long frame, String code, String reason) {

    /** Returns whether the command was accepted. */
    public boolean isAccepted() {
        return code.isEmpty();
    }
}
