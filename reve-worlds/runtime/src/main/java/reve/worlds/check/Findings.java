// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.LawReference;
import reve.core.file.Problem;
import reve.core.file.WorldDescription;

import java.util.ArrayList;
import java.util.List;

/**
 * Collector of warnings. The warning names the first item and the number of items if a check finds
 * several items.
 */
final class Findings {
    private final WorldDescription world;
    private final List<Problem> all = new ArrayList<>();

    Findings(WorldDescription world) {
        this.world = world;
    }

    List<Problem> all() {
        return all;
    }

    /**
     * Adds one warning for all items that have the same fault, or no warning if the list is empty.
     */
    void items(List<ItemFacts.Entry> found, String key, Message message) {
        if (!found.isEmpty()) {
            ItemFacts.Entry first = found.getFirst();
            all.add(
                    world.places()
                            .item(
                                    first.index(),
                                    key,
                                    message.about(first)
                                            + (found.size() == 1
                                                    ? ""
                                                    : " (and "
                                                            + (found.size() - 1)
                                                            + " more items like it)")));
        }
    }

    /** A function that returns the text of a warning about an item. */
    interface Message {
        String about(ItemFacts.Entry item);
    }

    void law(LawReference law, String message) {
        all.add(world.places().law(law, "law " + law.name() + ": " + message));
    }

    /** Adds a warning about the template of agents' bodies. */
    void template(String key, String message) {
        all.add(world.places().template(key, message));
    }

    void constant(String name, String message) {
        all.add(world.places().constant(name, "constants: " + message));
    }
}
