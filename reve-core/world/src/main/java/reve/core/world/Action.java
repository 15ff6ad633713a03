// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * Something that can be done to an item: what agents know of it. {@link PerformableAction} does it.
 * Implementations are immutable and shared by items.
 */
public interface Action {
    /** Unique within an item: {@code push}. */
    String name();

    /** One sentence for who wants to use it. */
    String doc();

    /** In the order in which they are documented; names are unique. */
    List<Parameter> parameters();

    /** Capabilities that the body which acts must have, in the order declared; none for anybody. */
    default List<String> needs() {
        return List.of();
    }
}
