// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.PreparedLibrary;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * A loaded law library, with all data that is needed to load it again.
 *
 * @param name the library's own name
 * @param sha256 of its bytes, 64 lower-case hexadecimal digits
 * @param parameters values, keyed by {@code parameter} or {@code law.parameter}; omitted ones have
 *     their default
 * @param bytes of the file; the caller must not change them
 */
public record LawLibrary(String name, String sha256, Map<String, Double> parameters, byte[] bytes) {
    /** Copies the parameters. */
    public LawLibrary {
        parameters = Collections.unmodifiableMap(new LinkedHashMap<>(parameters));
    }

    static LawLibrary of(PreparedLibrary prepared, Map<String, Double> parameters) {
        return new LawLibrary(prepared.name(), prepared.sha256(), parameters, prepared.bytes());
    }

    /** Returns this library with other values of some parameters. */
    LawLibrary with(Map<String, Double> changed) {
        Map<String, Double> all = new LinkedHashMap<>(parameters);
        all.putAll(changed);
        return new LawLibrary(name, sha256, all, bytes);
    }

    /** Returns whether the library is a law as text, and not native code. */
    public boolean isText() {
        return PreparedLibrary.isText(bytes);
    }

    /** Returns whether both have the same bytes and the same parameters. */
    boolean isSame(LawLibrary other) {
        return sha256.equals(other.sha256) && parameters.equals(other.parameters);
    }
}
