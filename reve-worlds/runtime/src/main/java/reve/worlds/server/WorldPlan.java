// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.file.WorldDescription;

/**
 * The plan of a world that a server runs.
 *
 * @param frames number of frames after which the world ends
 * @param persistence the store from which the world resumes, if there is one, and the data of the
 *     run that is stored
 * @param pictures taker of pictures of the world; the server closes it
 * @param laws search path of its laws
 * @param swaps the way in which new versions of its laws take over
 */
public record WorldPlan(
        WorldDescription description,
        long frames,
        Persistence persistence,
        Pictures pictures,
        LawPath laws,
        SwapPlan swaps) {

    /** Creates a plan in which new versions of laws take over in the standard way. */
    public WorldPlan(
            WorldDescription description,
            long frames,
            Persistence persistence,
            Pictures pictures,
            LawPath laws) {
        this(description, frames, persistence, pictures, laws, SwapPlan.STANDARD);
    }

    /** Creates a plan for a world that uses shipped laws only. */
    public WorldPlan(
            WorldDescription description, long frames, Persistence persistence, Pictures pictures) {
        this(description, frames, persistence, pictures, LawPath.ofShipped());
    }
}
