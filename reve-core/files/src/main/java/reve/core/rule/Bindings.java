// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import reve.core.world.Item;

import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/**
 * The values of an expression's names in one evaluation. They are the aspects of an item, and the
 * other names that the {@link Scope} permits. Numbers are in SI units. For the world's thread only.
 */
public final class Bindings {
    /** Maximum length of a value in a message [characters]. */
    private static final int MAX_DESCRIPTION = 100;

    private final Scope scope;
    private final ItemNames item;
    private final Map<String, Object> others = new HashMap<>();
    private long steps;

    Bindings(Scope scope) {
        this.scope = scope;
        this.item = new ItemNames(scope.own(), this::count);
    }

    /**
     * Sets the item to which the names {@code physics}, {@code physical}, {@code semantic} and
     * {@code item} refer.
     */
    public Bindings of(Item newItem) {
        item.of(newItem);
        return this;
    }

    /** Binds a name to a value: a Double, String, Boolean, or a List of these. */
    public Bindings with(String name, Object value) {
        others.put(name, value);
        return this;
    }

    /** Binds a name to another item, for example {@code actor} in {@code actor.physics.mass}. */
    public Bindings withItem(String name, Item other) {
        ItemNames names = new ItemNames(scope.other(), this::count);
        names.of(other);
        others.put(name, names.asMap());
        return this;
    }

    /**
     * Returns the number of steps of all evaluations with these bindings. The number includes
     * failed evaluations and the computation of relations that expressions read.
     */
    public long steps() {
        return steps;
    }

    void count(long more) {
        steps += more;
    }

    /**
     * Returns the value of a full name, such as {@code actor.physics.mass}, as text for messages.
     * Returns "missing" if the name has no value.
     */
    public String described(String nameInFull) {
        return value(nameInFull)
                .map(value -> shortened(value.toString(), MAX_DESCRIPTION))
                .orElse("missing");
    }

    /** Returns a text. Shortens it if it is longer than {@code most} characters. */
    static String shortened(String text, int most) {
        return text.length() <= most ? text : text.substring(0, most) + "…";
    }

    private Optional<Object> value(String nameInFull) {
        String[] parts = nameInFull.split("\\.");
        Optional<Object> value = find(parts[0]);
        for (int i = 1; i < parts.length && value.isPresent(); i++) {
            value =
                    value.get() instanceof Map<?, ?> map
                            ? Optional.ofNullable(map.get(parts[i]))
                            : Optional.empty();
        }
        return value;
    }

    Optional<Object> find(String name) {
        Object own = item.find(name);
        return Optional.ofNullable(own != null ? own : others.get(name));
    }
}
