// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.List;

/**
 * A change of a world by a command or by the program. Changes by laws and changes in the phase
 * DERIVE are not recorded. {@link World#changes()} returns the changes of a frame. Equal worlds
 * stay equal if these changes are applied to them in this order. Immutable.
 */
public sealed interface WorldChange {

    /** The aspect of an item that an edit changed. */
    enum Aspect {
        /** The physical aspect: place, shape and appearance of a body. */
        PHYSICAL,
        /** The semantic aspect: symbols. */
        SEMANTIC,
        /** The access aspect: actions and capabilities. */
        ACCESS,
        /** The physics aspect: physics properties. */
        PHYSICS
    }

    /**
     * Records that several items were added together.
     *
     * @param first id of the first item; the ids of the others follow without a gap
     * @param definitions initial states of the items
     * @param maker the agent whose action created the items; null otherwise
     */
    record Added(ItemId first, List<ItemDefinition> definitions, @Nullable String maker)
            implements WorldChange {

        /** Creates a change for items that no action created. */
        public Added(ItemId first, List<ItemDefinition> definitions) {
            this(first, definitions, null);
        }
    }

    /**
     * Records that an item was removed.
     *
     * @param cascade items that were removed with it because they referred to it or were attached
     *     to it
     */
    record Removed(ItemId item, String name, List<ItemId> cascade) implements WorldChange {}

    /** Records that an item was renamed. */
    record Renamed(ItemId item, String from, String to) implements WorldChange {}

    /**
     * Records that an item was attached to a parent.
     *
     * @param from the former attachment, null for none
     */
    record Attached(ItemId item, @Nullable Attachment from, Attachment to) implements WorldChange {}

    /** Records that an item was detached. */
    record Detached(ItemId item, Attachment from) implements WorldChange {}

    /**
     * Records that a part of an aspect was changed. The values have these types:
     *
     * <ul>
     *   <li>numbers of columns: {@code List<Double>}
     *   <li>references: {@code List<ItemId>}
     *   <li>symbols: text, truth value, Double or a list of these
     *   <li>appearance: {@link Shape}, {@link Colour} or {@link Material}
     *   <li>actions: {@link Action}
     * </ul>
     *
     * @param property the changed part: a physics property, a symbol, an action, or {@code
     *     location}, {@code orientation}, {@code shape}, {@code material}, {@code colour}
     * @param from the former value; null if there was none, for example if the item was scenery
     *     without physics properties
     * @param to the new value; null if it was removed
     */
    record Edited(
            ItemId item, Aspect aspect, String property, @Nullable Object from, @Nullable Object to)
            implements WorldChange {}

    /** Records that a force was added to an item. The force acts for a number of frames. */
    record Pushed(Force force) implements WorldChange {}

    /**
     * Records that numbers of any rows were written to a column directly, through {@link Column}.
     * This change is recorded once per frame and without values, because the column itself contains
     * them.
     */
    record ColumnEdited(String kind, String property) implements WorldChange {}

    /**
     * Records that the world was restored to the end of an earlier frame.
     *
     * @param frame the frame of the image
     */
    record Restored(long frame) implements WorldChange {}
}
