// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.PreparedLibrary;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * A law library as it was loaded: what it takes to load the very same again.
 *
 * @param name that the library gives itself
 * @param sha256 of its bytes, 64 lower-case hexadecimal digits
 * @param parameters by {@code parameter} or {@code law.parameter}; the rest have their default
 * @param bytes of the file; nobody changes them
 */
public record LawLibrary(String name, String sha256, Map<String, Double> parameters, byte[] bytes) {
    /** Copies the parameters. */
    public LawLibrary {
        parameters = Collections.unmodifiableMap(new LinkedHashMap<>(parameters));
    }

    static LawLibrary of(PreparedLibrary prepared, Map<String, Double> parameters) {
        return new LawLibrary(prepared.name(), prepared.sha256(), parameters, prepared.bytes());
    }

    /** Whether both act alike: the same bytes with the same parameters. */
    boolean isSame(LawLibrary other) {
        return sha256.equals(other.sha256) && parameters.equals(other.parameters);
    }
}
