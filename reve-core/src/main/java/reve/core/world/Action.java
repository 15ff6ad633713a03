// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/** Something that can be done to an item. Implementations are immutable and shared by items. */
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

    /**
     * Does it, in the phase ACT on the world's thread. Either all of it happens or none.
     *
     * @throws ActionRefused if it cannot be done now; nothing has happened then
     */
    void perform(ActionCall call) throws ActionRefused;
}
