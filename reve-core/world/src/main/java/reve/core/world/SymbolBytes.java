// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Map;

/**
 * Size of the designer's symbols in messages [bytes], and the limit that changes of a running world
 * keep. Each client that perceives an item receives its symbols, and a perception has at most 64
 * MiB.
 */
public final class SymbolBytes {
    /** Maximum size of the symbols of all items of a world after a change that enlarges them. */
    public static final long MOST = 16 << 20;

    private SymbolBytes() {}

    /** Returns the size of symbols by name. */
    public static long of(Map<String, Object> symbols) {
        return SymbolSizes.of(symbols);
    }

    /** Returns the size of the own symbols of an item. */
    public static long of(Item item) {
        return of(item.symbols().given());
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
        return Math.max(0, growth);
    }

    /**
     * Refuses a change that enlarges the symbols of a world beyond {@link #MOST}.
     *
     * @param growth the size that the change adds
     * @param code the code of the refusal
     */
    public static void require(World world, long growth, String code) throws ActionRefused {
        if (growth > 0 && world.symbolBytes() + growth > MOST) {
            throw new ActionRefused(
                    code,
                    "the symbols of all items would have "
                            + (world.symbolBytes() + growth)
                            + " bytes in messages, at most "
                            + MOST
                            + " are allowed; shorten symbols or remove items first");
        }
    }
}
