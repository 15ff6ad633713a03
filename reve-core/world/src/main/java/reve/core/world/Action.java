// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * Description of an action on an item, for agents. {@link PerformableAction} performs it.
 * Implementations are immutable and shared by items.
 */
public interface Action {
    /** Returns the name, unique within an item, for example {@code push}. */
    String name();

    /** Returns one sentence that describes the action to its callers. */
    String doc();

    /** Returns the parameters in the order of the documentation; their names are unique. */
    List<Parameter> parameters();

    /**
     * Returns the capabilities that the acting body needs, in the order of declaration; may be
     * empty.
     */
    default List<String> needs() {
        return List.of();
    }
}
