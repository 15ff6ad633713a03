// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

/**
 * What the designer of a world says of a semantic symbol, wherever it occurs.
 *
 * @param unit what a number is in; {@link Unit#ONE} for anything else
 */
public record SymbolDescriptor(String name, SymbolType type, Unit unit, String doc) {
    /** Most elements of a list. */
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
