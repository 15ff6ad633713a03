// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;

/**
 * Substances by name, with the values of contacts of their pairs. The class contains the shipped
 * substances; {@link SubstanceReader} adds those of a world file. The page {@code substances.md}
 * names the sources of the values. Immutable.
 */
final class Substances {
    /**
     * A substance.
     *
     * @param code value of the property {@code substance} of bodies; above 0. The codes of shipped
     *     substances never change, because saved worlds contain them
     * @param density [kg/m^3]; empty if it is not known
     * @param contact values of contacts with any other substance
     */
    record Substance(String name, int code, OptionalDouble density, Contact contact) {}

    /**
     * Values of the contacts of a substance or a pair, as far as they are known.
     *
     * @param friction coefficient of friction [1]
     * @param restitution coefficient of restitution [1]
     * @param rolling lever arm of the torque against rolling [m]
     * @param spinning lever arm of the torque against spinning [m]
     */
    record Contact(
            OptionalDouble friction,
            OptionalDouble restitution,
            OptionalDouble rolling,
            OptionalDouble spinning) {
        static final Contact UNKNOWN =
                new Contact(
                        OptionalDouble.empty(),
                        OptionalDouble.empty(),
                        OptionalDouble.empty(),
                        OptionalDouble.empty());

        static Contact of(double friction) {
            return new Contact(
                    OptionalDouble.of(friction),
                    OptionalDouble.empty(),
                    OptionalDouble.empty(),
                    OptionalDouble.empty());
        }

        static Contact of(double friction, double restitution) {
            return new Contact(
                    OptionalDouble.of(friction),
                    OptionalDouble.of(restitution),
                    OptionalDouble.empty(),
                    OptionalDouble.empty());
        }

        /** Returns these values, and those of another contact where this one knows none. */
        Contact or(Contact other) {
            return new Contact(
                    either(friction, other.friction),
                    either(restitution, other.restitution),
                    either(rolling, other.rolling),
                    either(spinning, other.spinning));
        }

        private static OptionalDouble either(OptionalDouble one, OptionalDouble other) {
            return one.isPresent() ? one : other;
        }
    }

    /**
     * The codes of two substances.
     *
     * @param first the smaller code
     */
    record Pair(int first, int second) implements Comparable<Pair> {
        static Pair of(int one, int other) {
            return new Pair(Math.min(one, other), Math.max(one, other));
        }

        @Override
        public int compareTo(Pair other) {
            return first == other.first
                    ? Integer.compare(second, other.second)
                    : Integer.compare(first, other.first);
        }
    }

    /** Code of the first substance of a world file. */
    static final int FIRST_OWN_CODE = 1001;

    /**
     * A value of contacts of 0 that a file states. Columns contain 0 where nothing is stated, so
     * they contain this number instead, which laws treat as 0.
     */
    static final double STATED_ZERO = 1e-12;

    private static final Substances SHIPPED = ship();

    private final Map<String, Substance> byName;
    private final Map<Pair, Contact> pairs;

    /** Copies the maps, in the order of the names and the pairs. */
    Substances(Map<String, Substance> byName, Map<Pair, Contact> pairs) {
        this.byName = new LinkedHashMap<>(byName);
        this.pairs = new TreeMap<>(pairs);
    }

    /** Returns the shipped substances. */
    static Substances shipped() {
        return SHIPPED;
    }

    private static Substances ship() {
        var builder = new Builder();
        builder.add("wood", 600, 0.3, 0.5);
        builder.add("steel", 7800, 0.3, 0.56);
        builder.add("aluminium", 2700, 0.5, 0.5);
        builder.add("copper", 8800, 0.4, 0.4);
        builder.add("lead", 11300, 0.4, 0.15);
        builder.add("ice", 917, 0.03, 0.3);
        builder.add("rubber", 1100, 1, 0.8);
        builder.add("concrete", 2400, 0.6, 0.3);
        builder.add("granite", 2700, 0.6, 0.4);
        builder.add("glass", 2600, 0.4, 0.94);
        builder.add("cork", 240, 0.4, 0.5);
        builder.add("teflon", 2200, 0.04, 0.4);
        builder.pair("steel", "ice", 0.02);
        builder.pair("steel", "teflon", 0.04);
        builder.pair("steel", "aluminium", 0.47);
        builder.pair("steel", "copper", 0.36);
        builder.pair("wood", "steel", 0.3);
        builder.pair("wood", "aluminium", 0.3);
        builder.pair("wood", "copper", 0.3);
        builder.pair("wood", "lead", 0.3);
        builder.pair("rubber", "concrete", 0.7);
        return new Substances(builder.byName, builder.pairs);
    }

    private static final class Builder {
        private final Map<String, Substance> byName = new LinkedHashMap<>();
        private final Map<Pair, Contact> pairs = new TreeMap<>();

        void add(String name, double density, double friction, double restitution) {
            byName.put(
                    name,
                    new Substance(
                            name,
                            byName.size() + 1,
                            OptionalDouble.of(density),
                            Contact.of(friction, restitution)));
        }

        void pair(String one, String other, double friction) {
            pairs.put(
                    Pair.of(byName.get(one).code(), byName.get(other).code()),
                    Contact.of(friction));
        }
    }

    /** Returns all substances: the shipped ones, then those of the file in its order. */
    Collection<Substance> all() {
        return byName.values();
    }

    /** Returns the pairs with values of their own, by codes. */
    Map<Pair, Contact> pairs() {
        return pairs;
    }

    Optional<Substance> find(String name) {
        return Optional.ofNullable(byName.get(name));
    }

    /**
     * Returns items of the kind {@link WorldPrototype#SUBSTANCE_PAIR}: one for each of these
     * substances, then one for each pair of them that has values of its own.
     *
     * @param codes the substances that the world uses
     */
    List<ItemDefinition> rows(Collection<Integer> codes) {
        var used = new TreeSet<>(codes);
        return rows(used, used);
    }

    /**
     * Returns items like {@link #rows(Collection)}, with all pairs of one of these substances and
     * any other substance. For items that are added to a world whose substances are not known.
     */
    List<ItemDefinition> rowsWithAny(Collection<Integer> codes) {
        var all = new TreeSet<Integer>();
        byName.values().forEach(substance -> all.add(substance.code()));
        return rows(new TreeSet<>(codes), all);
    }

    private List<ItemDefinition> rows(Set<Integer> used, Set<Integer> partners) {
        var names = new TreeMap<Integer, String>();
        List<ItemDefinition> rows = new ArrayList<>();
        for (Substance substance : byName.values()) {
            names.put(substance.code(), substance.name());
        }
        for (Substance substance : byName.values()) {
            if (used.contains(substance.code())) {
                rows.add(
                        row(
                                WorldPrototype.SUBSTANCE_PREFIX + substance.name(),
                                new Pair(0, substance.code()),
                                substance.contact()));
            }
        }
        pairs.forEach(
                (pair, contact) -> {
                    if (used.contains(pair.first()) && partners.contains(pair.second())
                            || partners.contains(pair.first()) && used.contains(pair.second())) {
                        rows.add(
                                row(
                                        "substances "
                                                + names.get(pair.first())
                                                + " "
                                                + names.get(pair.second()),
                                        pair,
                                        contact));
                    }
                });
        return rows;
    }

    private static ItemDefinition row(String name, Pair pair, Contact contact) {
        ItemDefinition.Builder row =
                ItemDefinition.named(name)
                        .kind(WorldPrototype.SUBSTANCE_PAIR)
                        .physics("substances", pair.first(), pair.second());
        contact.friction().ifPresent(value -> row.physics("pairFriction", stated(value)));
        contact.restitution().ifPresent(value -> row.physics("pairRestitution", stated(value)));
        contact.rolling()
                .ifPresent(
                        value -> row.physics(WorldPrototype.PAIR_ROLLING_FRICTION, stated(value)));
        contact.spinning()
                .ifPresent(value -> row.physics(WorldPrototype.PAIR_SPIN_FRICTION, stated(value)));
        return row.build();
    }

    /** Returns the number for a column that stands for a stated value. */
    static double stated(double value) {
        return value == 0 ? STATED_ZERO : value;
    }
}
