// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * A size that laws wrote for a body, and that the body's shape cannot have. For the world's thread
 * only.
 *
 * @param item the body, which keeps its shape
 * @param size the numbers that the laws wrote (3) [m]
 */
public record RefusedSize(Item item, List<Double> size) {

    /** Copies the list. */
    public RefusedSize {
        size = List.copyOf(size);
    }
}
