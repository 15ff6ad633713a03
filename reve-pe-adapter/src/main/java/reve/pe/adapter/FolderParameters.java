// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;

import java.nio.file.Path;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The parameters of a library in a watched folder, from the file beside it.
 *
 * @param values values, keyed by {@code parameter} or {@code law.parameter}, in SI units; other
 *     parameters have their default
 * @param check finds values whose unit does not fit a law
 */
public record FolderParameters(Map<String, Double> values, Check check) {

    /** The parameters of a library that has no file with parameters. */
    static final FolderParameters NONE = new FolderParameters(Map.of(), laws -> {});

    /** A function that checks parameters against the laws of the loaded library. */
    public interface Check {
        /**
         * Checks the units of the parameters.
         *
         * @throws PhysicsException if a unit does not fit; the message contains the line in the
         *     file
         */
        void check(List<PhysicsLaw> laws);
    }

    /** A function that reads files with parameters. For any thread. */
    public interface Reader {
        /**
         * Reads the parameters of a library.
         *
         * @param library name of the library
         * @throws PhysicsException if the file cannot be read or understood; the message contains
         *     the lines of all mistakes
         */
        FolderParameters read(String library, Path file);
    }

    /** Copies the values, in their order. */
    public FolderParameters {
        values = Collections.unmodifiableMap(new LinkedHashMap<>(values));
    }
}
