// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.frame.TimeBudget;
import reve.core.unit.Unit;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The reference of a world file to a physics law that the world requires.
 *
 * @param name name of the library that contains the law, for example {@code hooke_spring}; never a
 *     path
 * @param text the law as text, if the world file contains it; {@code name} is then the name of the
 *     first law in the text
 * @param parameters values [coherent SI units] by parameter name, in the order of the file
 * @param budget maximum time of the law in a frame, if the file states one
 * @param place position of the reference, as {@code file:line:column}, for messages
 * @param mentions positions and units of the parameters in the file, by name; empty without a file
 */
public record LawReference(
        String name,
        Optional<String> text,
        Map<String, Double> parameters,
        Optional<TimeBudget> budget,
        String place,
        Map<String, Mention> mentions) {
    /**
     * The occurrence of a parameter in a file.
     *
     * @param place as {@code file:line:column}
     * @param unit the unit in the file, if any
     */
    public record Mention(String place, Optional<Unit> unit) {}

    /** Copies the maps, in their order. */
    public LawReference {
        parameters = Collections.unmodifiableMap(new LinkedHashMap<>(parameters));
        mentions = Collections.unmodifiableMap(new LinkedHashMap<>(mentions));
    }

    /** Returns this reference with another budget. */
    LawReference withBudget(Optional<TimeBudget> other) {
        return new LawReference(name, text, parameters, other, place, mentions);
    }

    /** Creates a reference that is not in a file. */
    public LawReference(String name, Map<String, Double> parameters, String place) {
        this(name, Optional.empty(), parameters, Optional.empty(), place, Map.of());
    }

    /**
     * Returns the names of the parameters that a value sets. A vector parameter {@code w} of a law
     * as text has the three parameters {@code w_x}, {@code w_y} and {@code w_z}.
     *
     * @param numbers how many numbers the value has: 1, or 3 of a vector
     */
    public static List<String> parameterNames(String parameter, int numbers) {
        return numbers == 1
                ? List.of(parameter)
                : List.of(parameter + "_x", parameter + "_y", parameter + "_z");
    }
}
