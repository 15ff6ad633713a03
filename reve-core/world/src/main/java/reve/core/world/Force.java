// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * A force on an item.
 *
 * @param newtons in the world's reference frame (3) [N]
 * @param frames remaining number of frames
 */
public record Force(ItemId item, List<Double> newtons, long frames) {
    /** Copies the list. */
    public Force {
        newtons = List.copyOf(newtons);
    }
}
