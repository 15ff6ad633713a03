// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.Forces;

import java.util.List;

/**
 * A force that acts from the first frame on, as an action began it before the world was saved.
 *
 * @param item a body that takes part in physics
 * @param newtons in the world's frame (3) [N]
 * @param frames how many frames it acts, 1 to {@link Forces#MAX_FRAMES}
 */
public record LastingForce(String item, List<Double> newtons, long frames) {
    public LastingForce {
        newtons = List.copyOf(newtons);
    }
}
