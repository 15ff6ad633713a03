// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * A physics law that a world asks for.
 *
 * @param name of its library, never a path: {@code hooke_spring}
 * @param parameters values [coherent SI units] by parameter name, in the order of the file
 * @param place where it is asked for, as {@code file:line:column}, for messages
 * @param mentions how a file says the parameters, by their names; empty if no file does
 */
public record LawReference(
        String name, Map<String, Double> parameters, String place, Map<String, Mention> mentions) {
    /**
     * How a file says a parameter.
     *
     * @param place as {@code file:line:column}
     * @param unit that the file names
     */
    public record Mention(String place, Optional<Unit> unit) {}

    public LawReference {
        parameters = Collections.unmodifiableMap(new LinkedHashMap<>(parameters));
        mentions = Collections.unmodifiableMap(new LinkedHashMap<>(mentions));
    }

    /** A law that no file asks for. */
    public LawReference(String name, Map<String, Double> parameters, String place) {
        this(name, parameters, place, Map.of());
    }
}
