// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;

/**
 * Elements and attributes that a file contains but its reader ignores, with the number of their
 * occurrences.
 */
final class Ignored {
    private final Map<String, Integer> counts = new TreeMap<>();

    void add(String what) {
        counts.merge(what, 1, Integer::sum);
    }

    /**
     * Counts the attributes of an element that the reader ignores. Omits attributes whose numbers
     * are all 0.
     *
     * @param read names of the attributes that the reader reads
     */
    void attributes(XmlElement element, Set<String> read) {
        element.attributes()
                .forEach(
                        (name, value) -> {
                            if (!read.contains(name) && !value.matches("[\\s0.+-]*")) {
                                add(name + " of <" + element.name() + ">");
                            }
                        });
    }

    /** Returns one line for each ignored element or attribute. */
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
