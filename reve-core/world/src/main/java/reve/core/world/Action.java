// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * Description of an action that agents can perform on an item. {@link PerformableAction} adds the
 * method that performs the action. Implementations are immutable and shared by items.
 */
public interface Action {
    /** Returns the name, unique within an item, for example {@code push}. */
    String name();

    /** Returns one sentence that describes the action to its callers. */
    String doc();

    /** Returns the parameters in the order in which they are documented. Their names are unique. */
    List<Parameter> parameters();

    /**
     * Returns the names of the capabilities that the acting body needs, in the order of
     * declaration; empty if it needs none.
     */
    default List<String> needs() {
        return List.of();
    }
}
