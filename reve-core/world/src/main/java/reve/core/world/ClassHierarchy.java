// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;

/**
 * The classes of items that the designer of a world has declared. Each class has one parent:
 * another class or, at the top, a kind such as {@code body}. An item belongs to the class that its
 * symbol {@code class} names, and to all classes above it. It inherits their symbols; the symbols
 * of a class take precedence over those of the classes above it. A class without a declaration has
 * no classes above it. Immutable.
 */
public final class ClassHierarchy {

    /** The hierarchy of a world that declares no classes. */
    public static final ClassHierarchy NONE = new ClassHierarchy(List.of(), List.of());

    private static final PMap<String, Object> NO_SYMBOLS = TreePMap.empty();

    private final List<ItemClass> all;
    private final Map<String, Entry> entries = new LinkedHashMap<>();

    /**
     * A declared class with inherited values.
     *
     * @param lineage the class, the classes above it, nearest first, and the kind
     * @param bytes size of what an item inherits in messages, see {@link SymbolBytes}
     * @param properties initial values, also of the classes above
     */
    private record Entry(
            ItemClass declared,
            List<String> lineage,
            PMap<String, Object> symbols,
            long bytes,
            Map<String, List<Double>> properties) {}

    /**
     * @param kinds the kinds of the world, which are at the top of the hierarchy
     * @throws IllegalArgumentException naming the class that is declared twice, has the name of a
     *     kind, has an unknown parent, or is above itself
     */
    ClassHierarchy(List<ItemClass> classes, Collection<String> kinds) {
        all = List.copyOf(classes);
        Map<String, ItemClass> byName = new LinkedHashMap<>();
        for (ItemClass each : all) {
            if (kinds.contains(each.name())) {
                throw new IllegalArgumentException(
                        "class " + each.name() + " has the name of a kind, expected another name");
            }
            if (byName.putIfAbsent(each.name(), each) != null) {
                throw new IllegalArgumentException("class " + each.name() + " is declared twice");
            }
        }
        all.forEach(each -> entries.put(each.name(), entry(each, byName, kinds)));
    }

    private static Entry entry(
            ItemClass declared, Map<String, ItemClass> byName, Collection<String> kinds) {
        List<String> lineage = new ArrayList<>();
        Map<String, Object> symbols = new TreeMap<>();
        Map<String, List<Double>> properties = new TreeMap<>();
        String name = declared.name();
        for (ItemClass each = declared; each != null; each = byName.get(name)) {
            if (lineage.contains(name)) {
                throw new IllegalArgumentException(
                        "class "
                                + declared.name()
                                + ": classes are above themselves: "
                                + String.join(", ", lineage)
                                + ", "
                                + name);
            }
            lineage.add(name);
            each.symbols().forEach(symbols::putIfAbsent);
            inherit(properties, each.properties());
            name = each.parent();
        }
        if (!kinds.contains(name)) {
            throw new IllegalArgumentException(
                    "class " + lineage.getLast() + " is a " + name + ", which does not exist");
        }
        lineage.add(name);
        return new Entry(
                declared,
                List.copyOf(lineage),
                TreePMap.from(symbols),
                SymbolSizes.of(symbols) + SymbolSizes.of(StandardSymbols.CLASSES, lineage),
                Map.copyOf(properties));
    }

    /**
     * Adds inherited values to own ones. If the own values determine the mass, the inherited ones
     * do not.
     */
    static void inherit(Map<String, List<Double>> own, Map<String, List<Double>> inherited) {
        boolean hasMass = determinesMass(own);
        inherited.forEach(
                (property, values) -> {
                    if (!hasMass || !isOfMass(property)) {
                        own.putIfAbsent(property, values);
                    }
                });
    }

    private static boolean determinesMass(Map<String, ?> properties) {
        return properties.containsKey(WorldPrototype.MASS)
                || properties.containsKey(ItemClass.DENSITY);
    }

    private static boolean isOfMass(String property) {
        return property.equals(WorldPrototype.MASS)
                || property.equals(ItemClass.DENSITY)
                || property.equals("inertia");
    }

    /** Returns whether the world declares no classes. */
    public boolean isEmpty() {
        return all.isEmpty();
    }

    /** Returns the declared classes, in the order of declaration. */
    public List<ItemClass> all() {
        return all;
    }

    /** Returns the declaration of a class. */
    public Optional<ItemClass> find(String itemClass) {
        return Optional.ofNullable(entries.get(itemClass)).map(Entry::declared);
    }

    /**
     * Returns a class, the classes above it, nearest first, and the kind. Returns only the class
     * itself if it is not declared.
     */
    public List<String> lineage(String itemClass) {
        Entry entry = entries.get(itemClass);
        return entry == null ? List.of(itemClass) : entry.lineage;
    }

    /** Returns the kind of the items of a declared class. */
    public Optional<String> kind(String itemClass) {
        return Optional.ofNullable(entries.get(itemClass)).map(entry -> entry.lineage.getLast());
    }

    /** Returns whether a class is another class or below it. Allocates nothing. */
    public boolean isA(String itemClass, String other) {
        Entry entry = entries.get(itemClass);
        return entry == null ? itemClass.equals(other) : entry.lineage.contains(other);
    }

    /** Returns the symbols that items of a class inherit, by name, in alphabetical order. */
    public PMap<String, Object> symbols(String itemClass) {
        Entry entry = entries.get(itemClass);
        return entry == null ? NO_SYMBOLS : entry.symbols;
    }

    /** Returns the size in messages of what an item of a class inherits [bytes]. */
    long symbolBytes(String itemClass) {
        Entry entry = entries.get(itemClass);
        return entry == null ? 0 : entry.bytes;
    }

    /**
     * Returns the initial values of properties of items of a class, also those of the classes above
     * it; see {@link ItemClass#properties}.
     */
    public Map<String, List<Double>> properties(String itemClass) {
        Entry entry = entries.get(itemClass);
        return entry == null ? Map.of() : entry.properties;
    }

    /** Returns whether both hierarchies have the same declarations in the same order. */
    @Override
    public boolean equals(Object other) {
        return this == other || other instanceof ClassHierarchy that && all.equals(that.all);
    }

    @Override
    public int hashCode() {
        return all.hashCode();
    }
}
