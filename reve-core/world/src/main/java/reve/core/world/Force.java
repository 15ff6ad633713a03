// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * One force on one item.
 *
 * @param newtons in the world's frame (3) [N]
 * @param frames how many frames it still acts
 */
public record Force(ItemId item, List<Double> newtons, long frames) {
    /** Copies the list. */
    public Force {
        newtons = List.copyOf(newtons);
    }
}
