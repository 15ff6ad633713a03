// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.Forces;

import java.util.List;

/**
 * A force that acts from the first frame of a loaded world on. An action started it before the
 * world was saved.
 *
 * @param item name of a body with a physics aspect
 * @param newtons in the world's reference frame (3) [N]
 * @param frames remaining number of frames, 1 to {@link Forces#MAX_FRAMES}
 */
public record LastingForce(String item, List<Double> newtons, long frames) {
    /** Copies the list. */
    public LastingForce {
        newtons = List.copyOf(newtons);
    }
}
