// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** An action that can be performed. Items hold no others, but know them as {@link Action} only. */
public interface PerformableAction extends Action {
    /**
     * Does it, in the phase ACT on the world's thread. Either all of it happens or none.
     *
     * @throws ActionRefused if it cannot be done now; nothing has happened then
     */
    void perform(ActionCall call) throws ActionRefused;
}
