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
 * The symbolic data of an item. Immutable, so snapshots can share an object. A change creates a new
 * object.
 *
 * @param given the designer's symbols by name, in alphabetical order: String, Double, Boolean or a
 *     List of these
 * @param derived the symbols that rules set, in the same form
 * @param attachment attachment to a parent, or null
 * @param maker the agent whose action created the item; null for other items
 * @param classes the classes that the world declares, from which the item inherits symbols
 */
public record ItemSymbols(
        ItemId id,
        String name,
        Likeness likeness,
        PMap<String, Object> given,
        PMap<String, Object> derived,
        @Nullable Attachment attachment,
        @Nullable String maker,
        ClassHierarchy classes) {

    private static final PMap<String, Object> NO_SYMBOLS = TreePMap.empty();

    /** Creates the symbolic data of an item from its definition, without the attachment. */
    public ItemSymbols(ItemId id, ItemDefinition definition, ClassHierarchy classes) {
        this(id, definition, Likeness.of(definition), null, classes);
    }

    /**
     * Creates the symbolic data of an item from its definition, with an equal {@link Likeness} that
     * other items share.
     */
    ItemSymbols(
            ItemId id,
            ItemDefinition definition,
            Likeness likeness,
            @Nullable String maker,
            ClassHierarchy classes) {
        this(
                id,
                definition.name(),
                likeness,
                definition.symbols(),
                NO_SYMBOLS,
                null,
                maker,
                classes);
    }

    /** Returns the kind of the item. */
    public String kind() {
        return likeness.kind();
    }

    /** Returns the item as text for messages: {@code item ball (body #3)}. */
    String label() {
        return "item " + name + " (" + likeness.kind() + " " + id + ")";
    }

    /** Returns the shape of a body. */
    public Shape shape() {
        return likeness.shape();
    }

    /**
     * Returns the material of the whole shape. A mesh has its own materials if the result is empty.
     */
    public Optional<Material> material() {
        return likeness.material();
    }

    /** Returns the appearance of a spring or surface; the default for other kinds. */
    public ConnectionLook look() {
        return likeness.look();
    }

    /** Returns the actions on the item. */
    public List<Action> actions() {
        return likeness.actions();
    }

    /** Returns the capabilities of the item. */
    public List<String> capabilities() {
        return likeness.capabilities();
    }

    /**
     * Returns the sensors for an agent with this item as its body. The agent perceives everything
     * if the item has no sensors.
     */
    public List<Sensor> sensors() {
        return likeness.sensors();
    }

    /** Returns the voice of an agent with this item as its body; empty if it cannot speak. */
    public Optional<Voice> voice() {
        return likeness.voice();
    }

    /** Returns the levels of the item; empty for most items. */
    public List<Level> levels() {
        return likeness.levels();
    }

    /** Returns the class that the designer set, or the kind. */
    public String itemClass() {
        return given.getOrDefault(StandardSymbols.CLASS, kind()) instanceof String name
                ? name
                : kind();
    }

    /** Returns whether the item belongs to a class: its own class, or one above it. */
    public boolean isA(String itemClass) {
        return classes.isA(itemClass(), itemClass);
    }

    /** Returns a symbol of the designer, or a standard symbol, see {@link #symbols()}. */
    public Optional<Object> get(String symbol) {
        return switch (symbol) {
            case StandardSymbols.NAME -> Optional.of(name);
            case StandardSymbols.DIMENSIONS ->
                    shape() == Shape.none() ? Optional.empty() : Optional.of(dimensions());
            case StandardSymbols.CLASS ->
                    Optional.of(given.getOrDefault(StandardSymbols.CLASS, kind()));
            default -> {
                Object own = given.getOrDefault(symbol, derived.get(symbol));
                yield Optional.ofNullable(own == null ? inherited(symbol) : own);
            }
        };
    }

    private @Nullable Object inherited(String symbol) {
        if (classes.isEmpty()) {
            return null;
        }
        return symbol.equals(StandardSymbols.CLASSES)
                ? classes.lineage(itemClass())
                : classes.symbols(itemClass()).get(symbol);
    }

    /**
     * Returns all symbols as a new map, in this order:
     *
     * <ul>
     *   <li>the standard symbols {@code name}, {@code class} (by default the kind), if the world
     *       declares this class {@code classes}, and, if the item has a shape, {@code dimensions}
     *       (a list of three extents [m] along its own axes)
     *   <li>the designer's symbols, in alphabetical order
     *   <li>the symbols of rules, in alphabetical order
     *   <li>the symbols that the item inherits from its classes, in alphabetical order
     * </ul>
     */
    public Map<String, Object> symbols() {
        var all = new LinkedHashMap<String, Object>();
        all.put(StandardSymbols.NAME, name);
        all.put(StandardSymbols.CLASS, kind());
        String itemClass = classes.isEmpty() ? "" : itemClass();
        if (classes.find(itemClass).isPresent()) {
            all.put(StandardSymbols.CLASSES, classes.lineage(itemClass));
        }
        if (shape() != Shape.none()) {
            all.put(StandardSymbols.DIMENSIONS, dimensions());
        }
        all.putAll(given);
        derived.forEach(all::putIfAbsent);
        classes.symbols(itemClass).forEach(all::putIfAbsent);
        return all;
    }

    ItemSymbols with(String symbol, Object value) {
        return with(given.plus(symbol, value));
    }

    ItemSymbols without(String symbol) {
        return with(given.minus(symbol));
    }

    /** Returns a copy with these symbols instead of those that rules set; does not check them. */
    public ItemSymbols withDerived(Map<String, Object> symbols) {
        return withDerived(given(symbols));
    }

    ItemSymbols withDerived(PMap<String, Object> newDerived) {
        return new ItemSymbols(id, name, likeness, given, newDerived, attachment, maker, classes);
    }

    /** Returns a copy with these symbols instead of the designer's; does not check them. */
    public ItemSymbols withGiven(Map<String, Object> symbols) {
        return with(given(symbols));
    }

    ItemSymbols renamed(String newName) {
        return new ItemSymbols(id, newName, likeness, given, derived, attachment, maker, classes);
    }

    ItemSymbols with(Likeness newLikeness) {
        return new ItemSymbols(id, name, newLikeness, given, derived, attachment, maker, classes);
    }

    /** Returns a copy with another attachment. */
    public ItemSymbols attached(@Nullable Attachment newAttachment) {
        return new ItemSymbols(id, name, likeness, given, derived, newAttachment, maker, classes);
    }

    /** Returns a copy with this agent as the maker of the item. */
    public ItemSymbols madeBy(@Nullable String newMaker) {
        return new ItemSymbols(id, name, likeness, given, derived, attachment, newMaker, classes);
    }

    private ItemSymbols with(PMap<String, Object> newGiven) {
        return new ItemSymbols(id, name, likeness, newGiven, derived, attachment, maker, classes);
    }

    private List<Double> dimensions() {
        return List.of(shape().size(0), shape().size(1), shape().size(2));
    }

    private static PMap<String, Object> given(Map<String, Object> symbols) {
        return symbols.isEmpty() ? NO_SYMBOLS : TreePMap.from(symbols);
    }
}
