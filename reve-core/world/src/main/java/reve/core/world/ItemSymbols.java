// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * What is symbolic about an item. Immutable, so that snapshots share it; a change makes a new one.
 *
 * @param given the designer's symbols by name, in alphabetical order: String, Double, Boolean or a
 *     List of such
 * @param derived the symbols that rules give the item, in the same way
 * @param attachment what the item moves with, null for nothing
 * @param maker the agent whose action created the item, null for items that came otherwise
 */
public record ItemSymbols(
        ItemId id,
        String name,
        Likeness likeness,
        PMap<String, Object> given,
        PMap<String, Object> derived,
        @Nullable Attachment attachment,
        @Nullable String maker) {

    private static final PMap<String, Object> NO_SYMBOLS = TreePMap.empty();

    /** What is symbolic in a definition; attached to nothing, whatever it says. */
    public ItemSymbols(ItemId id, ItemDefinition definition) {
        this(id, definition, Likeness.of(definition), null);
    }

    /** As the other one, sharing a likeness that is equal to the definition's. */
    ItemSymbols(ItemId id, ItemDefinition definition, Likeness likeness, @Nullable String maker) {
        this(id, definition.name(), likeness, definition.symbols(), NO_SYMBOLS, null, maker);
    }

    /** The kind of the item. */
    public String kind() {
        return likeness.kind();
    }

    /** The item for a person: {@code item ball (body #3)}. */
    String label() {
        return "item " + name + " (" + likeness.kind() + " " + id + ")";
    }

    /** The shape of a body. */
    public Shape shape() {
        return likeness.shape();
    }

    /** Of the whole shape; without it, a mesh shows its own. */
    public Optional<Material> material() {
        return likeness.material();
    }

    /** What can be done with the item. */
    public List<Action> actions() {
        return likeness.actions();
    }

    /** What the item can do with others. */
    public List<String> capabilities() {
        return likeness.capabilities();
    }

    /** What an agent that has the item as its body perceives with; none for everything. */
    public List<Sensor> sensors() {
        return likeness.sensors();
    }

    /** A designer's symbol, or a standard one: see {@link #symbols()}. */
    public Optional<Object> get(String symbol) {
        return switch (symbol) {
            case StandardSymbols.NAME -> Optional.of(name);
            case StandardSymbols.DIMENSIONS ->
                    shape() == Shape.none() ? Optional.empty() : Optional.of(dimensions());
            case StandardSymbols.CLASS ->
                    Optional.of(given.getOrDefault(StandardSymbols.CLASS, kind()));
            default -> Optional.ofNullable(given.getOrDefault(symbol, derived.get(symbol)));
        };
    }

    /**
     * All symbols: first the standard ones {@code name}, {@code class} (the kind unless the
     * designer says otherwise) and, if the item has a shape, {@code dimensions} (a list of three
     * extents [m] along its own axes), then the designer's and then those of rules, both in
     * alphabetical order. A new map each time.
     */
    public Map<String, Object> symbols() {
        var all = new LinkedHashMap<String, Object>();
        all.put(StandardSymbols.NAME, name);
        all.put(StandardSymbols.CLASS, kind());
        if (shape() != Shape.none()) {
            all.put(StandardSymbols.DIMENSIONS, dimensions());
        }
        all.putAll(given);
        derived.forEach(all::putIfAbsent);
        return all;
    }

    ItemSymbols with(String symbol, Object value) {
        return with(given.plus(symbol, value));
    }

    ItemSymbols without(String symbol) {
        return with(given.minus(symbol));
    }

    /** The same with other symbols of rules, which are not checked. */
    public ItemSymbols withDerived(Map<String, Object> symbols) {
        return withDerived(given(symbols));
    }

    ItemSymbols withDerived(PMap<String, Object> newDerived) {
        return new ItemSymbols(id, name, likeness, given, newDerived, attachment, maker);
    }

    /** The same with other symbols of the designer's, which are not checked. */
    public ItemSymbols withGiven(Map<String, Object> symbols) {
        return with(given(symbols));
    }

    ItemSymbols renamed(String newName) {
        return new ItemSymbols(id, newName, likeness, given, derived, attachment, maker);
    }

    ItemSymbols with(Likeness newLikeness) {
        return new ItemSymbols(id, name, newLikeness, given, derived, attachment, maker);
    }

    /** The same with another attachment. */
    public ItemSymbols attached(@Nullable Attachment newAttachment) {
        return new ItemSymbols(id, name, likeness, given, derived, newAttachment, maker);
    }

    /** The same, created by an action of that agent. */
    public ItemSymbols madeBy(@Nullable String newMaker) {
        return new ItemSymbols(id, name, likeness, given, derived, attachment, newMaker);
    }

    private ItemSymbols with(PMap<String, Object> newGiven) {
        return new ItemSymbols(id, name, likeness, newGiven, derived, attachment, maker);
    }

    private List<Double> dimensions() {
        return List.of(shape().size(0), shape().size(1), shape().size(2));
    }

    private static PMap<String, Object> given(Map<String, Object> symbols) {
        return symbols.isEmpty() ? NO_SYMBOLS : TreePMap.from(symbols);
    }
}
