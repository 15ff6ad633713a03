package reve.core.world;

import java.util.Map;
import java.util.Optional;

/** What agents perceive of an item: symbols with text, truth or a number. World's thread only. */
public final class SemanticAspect {

    private final Item item;

    SemanticAspect(Item item) {
        this.item = item;
    }

    /** A designer's symbol or a standard one ({@code name}, {@code class}, {@code dimensions}). */
    public Optional<Object> get(String symbol) {
        item.checkedRow();
        return item.symbols().get(symbol);
    }

    /**
     * Sets a symbol.
     *
     * @param value String, Boolean or a finite number
     * @throws IllegalArgumentException naming item and symbol for any other value, and for the
     *     symbols that the world derives
     */
    public void set(String symbol, Object value) {
        item.checkedRow();
        Object checked = Values.requireSymbol(item.name(), symbol, value);
        item.world().setSymbols(item, item.symbols().with(symbol, checked));
    }

    /** Forgets a designer's symbol, if there. */
    public void remove(String symbol) {
        item.checkedRow();
        item.world().setSymbols(item, item.symbols().without(symbol));
    }

    /** All symbols, standard ones first: see {@link ItemSymbols#symbols()}. */
    public Map<String, Object> symbols() {
        item.checkedRow();
        return item.symbols().symbols();
    }
}
