// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import reve.core.frame.FrameBus;
import reve.core.frame.FramePhase;
import reve.core.world.FrameControl;

/**
 * The first listener of the phase DERIVE. It updates all columns that are derived from other
 * columns.
 */
public final class DerivedColumns {

    private DerivedColumns() {}

    /**
     * Subscribes to the phase DERIVE. The listener computes the places of attached items in every
     * frame, then the boxes of all bodies.
     */
    public static void subscribeTo(FrameBus bus) {
        var boxes = new BoundingBoxes();
        bus.subscribe(
                FramePhase.DERIVE,
                "derived columns",
                event -> {
                    FrameControl.of(event.world()).placeAttached();
                    boxes.update(event.world());
                });
    }
}
