// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * An action that can be performed. All actions of items implement this interface, but most code
 * uses only {@link Action}.
 */
public interface PerformableAction extends Action {
    /**
     * Performs the action completely or not at all. Called in the phase ACT on the world's thread.
     *
     * @throws ActionRefused if the action is not possible now; the world is then unchanged
     */
    void perform(ActionCall call) throws ActionRefused;
}
