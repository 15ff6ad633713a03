package reve.core.file;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * A physics law that a world asks for.
 *
 * @param name as the engine looks it up: {@code hooke_spring}
 * @param parameters values [coherent SI units] by parameter name, in the order of the file
 * @param place where it is asked for, as {@code file:line:column}, for messages
 */
public record LawReference(String name, Map<String, Double> parameters, String place) {
    public LawReference {
        parameters = Collections.unmodifiableMap(new LinkedHashMap<>(parameters));
    }
}
