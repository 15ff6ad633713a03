// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SymbolDescriptor;
import reve.core.world.WorldPrototype;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/** The names that expressions may use in the aspects of items of one kind. Immutable. */
final class KindNames {
    static final String PHYSICS = "physics";
    static final String PHYSICAL = "physical";
    static final String SEMANTIC = "semantic";
    static final String SELF = "item";

    /** Names that {@code item} has in addition to its aspects. */
    static final Set<String> ITEM_NAMES = Set.copyOf(List.of("name", "kind"));

    /** Name of the physical aspect for the volume of the shape [m^3]. */
    static final String VOLUME = "volume";

    /** Name of the physical aspect for whether laws can move the body. */
    static final String MOVABLE = "movable";

    /** Name of the physical aspect for the name of the body's substance. */
    static final String SUBSTANCE = "substance";

    /** Number of components of a text in {@link #physicalNames}. */
    static final int TEXT = 0;

    /** Number of components of a truth value in {@link #physicalNames}. */
    static final int TRUTH = -1;

    private static final Map<String, Integer> PHYSICAL_NAMES =
            Map.of(
                    "location",
                    3,
                    "orientation",
                    4,
                    "size",
                    3,
                    "colour",
                    TEXT,
                    VOLUME,
                    1,
                    MOVABLE,
                    TRUTH,
                    SUBSTANCE,
                    TEXT);

    private final String kind;
    private final Map<String, PropertyDescriptor> properties = new LinkedHashMap<>();
    private final Map<String, SymbolDescriptor> symbols = new LinkedHashMap<>();

    KindNames(WorldPrototype prototype, String kind) {
        this.kind = kind;
        for (PropertyDescriptor property : prototype.properties()) {
            if (property.kind().equals(kind) && property.type() != ScalarType.REF) {
                properties.put(property.name(), property);
            }
        }
        prototype.symbols().forEach(symbol -> symbols.put(symbol.name(), symbol));
    }

    String kind() {
        return kind;
    }

    Set<String> physicsNames() {
        return properties.keySet();
    }

    @Nullable PropertyDescriptor property(String name) {
        return properties.get(name);
    }

    /**
     * Returns the names of the physical aspect, with the number of components of their values,
     * {@link #TEXT} or {@link #TRUTH}. Returns none for kinds without a place.
     */
    Map<String, Integer> physicalNames() {
        return kind.equals(WorldPrototype.BODY) ? PHYSICAL_NAMES : Map.of();
    }

    /** Returns the symbols with a declared type. */
    Map<String, SymbolDescriptor> symbols() {
        return symbols;
    }

    /** Converts a symbol's number from its declared unit into SI units. */
    double toSi(String symbol, double number) {
        SymbolDescriptor declared = symbols.get(symbol);
        return declared == null ? number : declared.unit().toSi(number);
    }
}
