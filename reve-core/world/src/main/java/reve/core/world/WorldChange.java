// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.List;

/**
 * Something in a world that became different because somebody said so: not by a law, and not worked
 * out in DERIVE. {@link World#changes()} has those of a frame, in an order that makes an equal
 * world of an equal one. Immutable.
 */
public sealed interface WorldChange {

    /** The part of an item that an edit changed. */
    enum Aspect {
        /** Where a body is and what it looks like. */
        PHYSICAL,
        /** Its symbols. */
        SEMANTIC,
        /** What agents can do with it. */
        ACCESS,
        /** Its properties in laws. */
        PHYSICS
    }

    /**
     * Items came, all at once, as their definitions say.
     *
     * @param first the id of the first one; those of the others follow without a gap
     * @param maker the agent whose action created them, null if they came otherwise
     */
    record Added(ItemId first, List<ItemDefinition> definitions, @Nullable String maker)
            implements WorldChange {

        /** Items that no action created. */
        public Added(ItemId first, List<ItemDefinition> definitions) {
            this(first, definitions, null);
        }
    }

    /**
     * An item went.
     *
     * @param cascade those that went with it because they referred to it or were attached to it
     */
    record Removed(ItemId item, String name, List<ItemId> cascade) implements WorldChange {}

    /** An item is called something else. */
    record Renamed(ItemId item, String from, String to) implements WorldChange {}

    /**
     * An item moves with another from now on.
     *
     * @param from what it was attached to before, null for nothing
     */
    record Attached(ItemId item, @Nullable Attachment from, Attachment to) implements WorldChange {}

    /** An item moves on its own again. */
    record Detached(ItemId item, Attachment from) implements WorldChange {}

    /**
     * Part of an aspect got another value. Numbers of columns are a {@code List<Double>},
     * references a {@code List<ItemId>}, symbols text, truth, Double or a list of such; what an
     * item looks like is a {@link Shape}, {@link Colour} or {@link Material}, and what it can do an
     * {@link Action}.
     *
     * @param property the part: a physics property, a symbol, an action, or {@code location},
     *     {@code orientation}, {@code shape}, {@code material}, {@code colour}
     * @param from null if the item had none: scenery no physics property, an item no such symbol
     * @param to null if the item has none from now on
     */
    record Edited(
            ItemId item, Aspect aspect, String property, @Nullable Object from, @Nullable Object to)
            implements WorldChange {}

    /** A force acts on an item from now on, for some frames. */
    record Pushed(Force force) implements WorldChange {}

    /**
     * Numbers of any rows were written to a column directly, through {@link Column}. Told once a
     * frame; what they are now the column says.
     */
    record ColumnEdited(String kind, String property) implements WorldChange {}

    /**
     * The world became as it was at the end of an earlier frame, in all it is.
     *
     * @param frame the frame of the image
     */
    record Restored(long frame) implements WorldChange {}
}
