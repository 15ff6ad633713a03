// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.TimeBudget;
import reve.pe.PreparedLibrary;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * A loaded law library, with all data that is needed to load it again.
 *
 * @param name the library's own name
 * @param sha256 SHA-256 of its bytes, 64 lower-case hexadecimal digits
 * @param parameters values, keyed by {@code parameter} or {@code law.parameter}; omitted parameters
 *     have their default
 * @param bytes content of the file; the caller must not change it
 * @param budget limit of the library's time in a frame, if it has one
 * @param interval 1, or n if its laws are evaluated in every n-th step only
 * @param versions versions of the programs on which its results depend, see {@link
 *     PreparedLibrary#versions()}
 */
public record LawLibrary(
        String name,
        String sha256,
        Map<String, Double> parameters,
        byte[] bytes,
        Optional<TimeBudget> budget,
        int interval,
        String versions) {
    /** Copies the parameters. */
    public LawLibrary {
        parameters = Collections.unmodifiableMap(new LinkedHashMap<>(parameters));
    }

    static LawLibrary of(PreparedLibrary prepared, Map<String, Double> parameters) {
        return new LawLibrary(
                prepared.name(),
                prepared.sha256(),
                parameters,
                prepared.bytes(),
                Optional.empty(),
                1,
                prepared.versions());
    }

    /** Returns this library with other values of some parameters. */
    LawLibrary with(Map<String, Double> changed) {
        Map<String, Double> all = new LinkedHashMap<>(parameters);
        all.putAll(changed);
        return new LawLibrary(name, sha256, all, bytes, budget, interval, versions);
    }

    /** Returns this library with another budget. */
    LawLibrary withBudget(Optional<TimeBudget> other) {
        return new LawLibrary(name, sha256, parameters, bytes, other, interval, versions);
    }

    /** Returns this library with another interval of its steps. */
    LawLibrary withInterval(int other) {
        return new LawLibrary(name, sha256, parameters, bytes, budget, other, versions);
    }

    /** Returns this library with other versions of the programs on which its results depend. */
    LawLibrary withVersions(String other) {
        return new LawLibrary(name, sha256, parameters, bytes, budget, interval, other);
    }

    /** Returns whether the library is a law as text, and not native code. */
    public boolean isText() {
        return PreparedLibrary.isText(bytes);
    }

    /** Returns whether both libraries have the same bytes and the same parameters. */
    boolean isSame(LawLibrary other) {
        return sha256.equals(other.sha256) && parameters.equals(other.parameters);
    }
}
