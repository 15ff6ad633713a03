// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.Map;

/**
 * Size of the designer's symbols in messages [bytes], and the limit that changes of a running world
 * keep. Each client that perceives an item receives its symbols, also those that it inherits from
 * its class, and a perception has at most 64 MiB.
 */
public final class SymbolBytes {
    /** Maximum size of the symbols of all items of a world after a change that enlarges them. */
    public static final long MOST = 16 << 20;

    private SymbolBytes() {}

    /** Returns the size of the symbols of an item that is not in the world yet. */
    public static long of(World world, ItemDefinition item) {
        return SymbolSizes.of(item.symbols())
                + inherited(world.prototype().classes(), item.symbols().get(StandardSymbols.CLASS));
    }

    /** Returns the size of symbols that a change adds to an item that is not in the world yet. */
    public static long of(World world, Map<String, Object> symbols) {
        return SymbolSizes.of(symbols)
                + inherited(world.prototype().classes(), symbols.get(StandardSymbols.CLASS));
    }

    /** Returns the size of the symbols of an item. */
    public static long of(Item item) {
        return of(item.symbols());
    }

    static long of(ItemSymbols item) {
        return SymbolSizes.of(item.given()) + item.classes().symbolBytes(item.itemClass());
    }

    private static long inherited(ClassHierarchy classes, @Nullable Object itemClass) {
        return itemClass instanceof String name ? classes.symbolBytes(name) : 0;
    }

    /**
     * Returns by how much a new value of a symbol enlarges the symbols of an item. A shorter value
     * counts with 0, because several changes of a message may set the same symbol.
     */
    public static long growth(Item item, String symbol, Object value) {
        Object before = item.symbols().given().get(symbol);
        long growth =
                SymbolSizes.of(symbol, value)
                        - (before == null ? 0 : SymbolSizes.of(symbol, before));
        if (symbol.equals(StandardSymbols.CLASS)) {
            ClassHierarchy classes = item.symbols().classes();
            growth += inherited(classes, value) - classes.symbolBytes(item.symbols().itemClass());
        }
        return Math.max(0, growth);
    }

    /**
     * Refuses a change that enlarges the symbols of a world beyond {@link #MOST}.
     *
     * @param growth the size that the change adds
     * @param code the code of the refusal
     */
    public static void require(World world, long growth, String code) throws ActionRefused {
        require(world, growth, MOST, code);
    }

    static void require(World world, long growth, long most, String code) throws ActionRefused {
        if (growth > 0 && world.symbolBytes() + growth > most) {
            throw new ActionRefused(
                    code,
                    "the symbols of all items would have "
                            + (world.symbolBytes() + growth)
                            + " bytes in messages, at most "
                            + most
                            + " are allowed; shorten symbols or remove items first, in a message"
                            + " before this one");
        }
    }
}
