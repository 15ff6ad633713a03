// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import reve.core.world.Item;

import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/**
 * What the names of an expression stand for while it is evaluated: the aspects of an item, and
 * whatever else its {@link Scope} knows. Numbers are in SI units. World's thread.
 */
public final class Bindings {
    /** Most characters of one value in a message. */
    private static final int MAX_DESCRIPTION = 100;

    private final Scope scope;
    private final ItemNames item;
    private final Map<String, Object> others = new HashMap<>();
    private long steps;

    Bindings(Scope scope) {
        this.scope = scope;
        this.item = new ItemNames(scope.own(), this::count);
    }

    /** From now on {@code physics}, {@code physical}, {@code semantic} and {@code item} are its. */
    public Bindings of(Item newItem) {
        item.of(newItem);
        return this;
    }

    /** A value by name: a Double, String, Boolean, or a List of such. */
    public Bindings with(String name, Object value) {
        others.put(name, value);
        return this;
    }

    /** Another item by name: {@code actor.physics.mass}. */
    public Bindings withItem(String name, Item other) {
        ItemNames names = new ItemNames(scope.other(), this::count);
        names.of(other);
        others.put(name, names.asMap());
        return this;
    }

    /**
     * Steps of all evaluations with these values, also of those that failed, and of finding the
     * relations that they read.
     */
    public long steps() {
        return steps;
    }

    void count(long more) {
        steps += more;
    }

    /** For messages, what a name in full stands for now: {@code actor.physics.mass}. */
    public String described(String nameInFull) {
        return value(nameInFull)
                .map(value -> shortened(value.toString(), MAX_DESCRIPTION))
                .orElse("missing");
    }

    /** The beginning of a text that may be long. */
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
