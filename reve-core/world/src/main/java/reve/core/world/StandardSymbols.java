// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Set;

/** Names of the symbols that every item has without a declaration. */
public final class StandardSymbols {

    static final String NAME = "name";
    static final String CLASS = "class";
    static final String DIMENSIONS = "dimensions";
    static final String LOCATION = "location";

    /**
     * Name of the symbol for the classes of an item: a list of the item's class, the classes above
     * it, nearest first, and the kind. Only worlds that declare classes have this symbol, see
     * {@link ClassHierarchy}.
     */
    public static final String CLASSES = "classes";

    /** Standard symbols that only the world itself sets. */
    public static final Set<String> DERIVED =
            Set.of(NAME, DIMENSIONS, LOCATION, "near", "on", "inside", "touching");

    private StandardSymbols() {}
}
