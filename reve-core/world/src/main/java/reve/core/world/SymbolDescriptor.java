// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

/**
 * The designer's declaration of a symbol's type and unit, valid for all items.
 *
 * @param unit unit of a number; {@link Unit#ONE} for other types
 */
public record SymbolDescriptor(String name, SymbolType type, Unit unit, String doc) {
    /** Maximum number of elements of a list. */
    public static final int MAX_ELEMENTS = 64;

    /** Checks name and unit. */
    public SymbolDescriptor {
        Names.require("symbol name", name);
        if (StandardSymbols.DERIVED.contains(name)) {
            throw new IllegalArgumentException(
                    "symbol " + name + " is derived by the world; it cannot be declared");
        }
        if (type != SymbolType.NUMBER && !unit.equals(Unit.ONE)) {
            throw new IllegalArgumentException("symbol " + name + ": only a number has a unit");
        }
    }
}
