// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import reve.core.frame.FrameBus;
import reve.core.frame.FramePhase;

/** Keeps all columns that follow from others current: the first listener of DERIVE. */
public final class DerivedColumns {

    private DerivedColumns() {}

    /**
     * Works out, in DERIVE of every frame and in this order, where attached items are and the boxes
     * around all bodies.
     */
    public static void subscribeTo(FrameBus bus) {
        var boxes = new BoundingBoxes();
        bus.subscribe(
                FramePhase.DERIVE,
                "derived columns",
                event -> {
                    event.world().placeAttached();
                    boxes.update(event.world());
                });
    }
}
