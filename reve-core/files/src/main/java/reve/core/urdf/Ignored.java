// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;

/** What a file contains and its reader leaves out, with the number of occurrences. */
final class Ignored {
    private final Map<String, Integer> counts = new TreeMap<>();

    void add(String what) {
        counts.merge(what, 1, Integer::sum);
    }

    /** Adds the attributes of an element that are not read, except those that are 0. */
    void attributes(XmlElement element, Set<String> read) {
        element.attributes()
                .forEach(
                        (name, value) -> {
                            if (!read.contains(name) && !value.matches("[\\s0.+-]*")) {
                                add(name + " of <" + element.name() + ">");
                            }
                        });
    }

    /** Returns a line for each. */
    List<String> lines() {
        return counts.entrySet().stream()
                .map(
                        entry ->
                                entry.getKey()
                                        + (entry.getValue() == 1
                                                ? ""
                                                : " (" + entry.getValue() + " times)"))
                .toList();
    }
}
