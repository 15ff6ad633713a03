// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * A small map from names to values, in the order of the names. Copies with the same names share the
 * array of names. Immutable.
 */
final class Named<V> {

    private final List<String> names;
    private final List<V> values;

    private Named(List<String> names, List<V> values) {
        this.names = names;
        this.values = values;
    }

    static <V> Named<V> none() {
        return new Named<>(List.of(), List.of());
    }

    /** Returns a copy with the value added or replaced. */
    Named<V> with(String name, V value) {
        int index = names.indexOf(name);
        if (index >= 0) {
            List<V> others = new ArrayList<>(values);
            others.set(index, value);
            return new Named<>(names, List.copyOf(others));
        }
        return new Named<>(append(names, name), append(values, value));
    }

    /** Returns a copy with several values added or replaced, in their order. */
    Named<V> withAll(Map<String, V> more) {
        if (isEmpty()) {
            return new Named<>(List.copyOf(more.keySet()), List.copyOf(more.values()));
        }
        Named<V> all = this;
        for (Map.Entry<String, V> each : more.entrySet()) {
            all = all.with(each.getKey(), each.getValue());
        }
        return all;
    }

    @Nullable V get(String name) {
        int index = names.indexOf(name);
        return index < 0 ? null : values.get(index);
    }

    List<String> names() {
        return names;
    }

    /** Returns the values, in the order of the names. */
    List<V> values() {
        return values;
    }

    boolean isEmpty() {
        return names.isEmpty();
    }

    /** Returns a copy as a map, in the same order. */
    Map<String, V> toMap() {
        var map = new LinkedHashMap<String, V>();
        for (int i = 0; i < names.size(); i++) {
            map.put(names.get(i), values.get(i));
        }
        return map;
    }

    /** Returns a list with one more element. */
    static <E> List<E> append(List<E> list, E element) {
        List<E> longer = new ArrayList<>(list.size() + 1);
        longer.addAll(list);
        longer.add(element);
        return List.copyOf(longer);
    }
}
