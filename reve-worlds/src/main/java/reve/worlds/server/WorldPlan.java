// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.file.WorldDescription;

/**
 * A world that a server is to run.
 *
 * @param frames to make, then it ends
 * @param persistence where it comes from, if it is stored, and what is kept of the run
 * @param pictures to be taken of it; closed by the server
 * @param laws where its laws are found
 */
public record WorldPlan(
        WorldDescription description,
        long frames,
        Persistence persistence,
        Pictures pictures,
        LawPath laws) {

    /** A world of laws that ship. */
    public WorldPlan(
            WorldDescription description, long frames, Persistence persistence, Pictures pictures) {
        this(description, frames, persistence, pictures, LawPath.ofShipped());
    }
}
