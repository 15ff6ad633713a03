package reve.core.world;

import java.util.Map;
import java.util.Optional;
import org.jspecify.annotations.Nullable;

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
     * Checks a symbol that is to be set later.
     *
     * @param item name of its item, for messages
     * @return the value as {@link #set} keeps it: text, truth, a Double or a list of such
     * @throws IllegalArgumentException as {@link #set}
     */
    public static Object requireSettable(WorldPrototype prototype, String item, String symbol,
            Object value) {
        return Values.requireSymbol(prototype, item, symbol, value);
    }

    /**
     * Sets a symbol.
     *
     * @param value String, Boolean, a finite number or a List of such, of the type that the
     *     prototype declares for the symbol, if it does
     * @throws IllegalArgumentException naming item and symbol for any other value, and for the
     *     symbols that the world derives
     */
    public void set(String symbol, Object value) {
        item.checkedRow();
        Object checked = requireSettable(item.world().prototype(), item.name(), symbol,
                value);
        change(symbol, checked, item.symbols().with(symbol, checked));
    }

    /** Forgets a designer's symbol, if there. */
    public void remove(String symbol) {
        item.checkedRow();
        if (item.symbols().given().containsKey(symbol)) {
            change(symbol, null, item.symbols().without(symbol));
        }
    }

    /** All symbols, standard ones first: see {@link ItemSymbols#symbols()}. */
    public Map<String, Object> symbols() {
        item.checkedRow();
        return item.symbols().symbols();
    }

    private void change(String symbol, @Nullable Object to, ItemSymbols changed) {
        Object from = item.symbols().given().get(symbol);
        item.world().setSymbols(item, changed);
        item.world().note(
                new WorldChange.Edited(item.id(), WorldChange.Aspect.SEMANTIC, symbol, from, to));
    }
}
