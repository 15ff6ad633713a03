// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;

/**
 * The designer's declaration of a class of items, see {@link ClassHierarchy}.
 *
 * @param name value of the symbol {@code class} of the items
 * @param parent class or kind directly above this class. Every item of this class is also one of
 *     the parent
 * @param symbols symbols that the items inherit, by name, in alphabetical order: String, Double,
 *     Boolean or a List of these
 * @param properties initial values of physics properties, by name, in alphabetical order [the
 *     property's unit]. The key {@link #DENSITY} is a density [kg/m^3], from which the mass of a
 *     body follows
 */
public record ItemClass(
        String name,
        String parent,
        String doc,
        Map<String, Object> symbols,
        Map<String, List<Double>> properties) {

    /** Key of {@link #properties} for a density. */
    public static final String DENSITY = "density";

    /** Checks the name, and copies the maps. */
    public ItemClass {
        Names.require("class name", name);
        symbols = Collections.unmodifiableMap(new TreeMap<>(symbols));
        properties = Collections.unmodifiableMap(new TreeMap<>(properties));
    }
}
