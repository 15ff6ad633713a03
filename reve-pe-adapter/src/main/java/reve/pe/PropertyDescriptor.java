// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import org.jspecify.annotations.Nullable;

import java.util.Objects;
import java.util.Set;

/**
 * Declares one property of a prototype.
 *
 * @param name unique within the prototype, at most 47 bytes of UTF-8
 * @param kind row space: all properties of a kind have the same number of rows
 * @param components values per row, at least 1
 * @param lawAccess the most that any law may ask for
 * @param refersTo kind that this U32 property's values are rows of, or null
 * @param initialFrom for accumulators: property of the same kind, type and unit that each stage's
 *     sum starts from instead of zero, or null
 * @param minimum least value that the client's arrays may hold [unit], for reals that laws only
 *     read; negative infinity for any
 * @param doc one line, may be empty
 */
public record PropertyDescriptor(
        String name,
        String kind,
        ScalarType type,
        int components,
        Set<Access> lawAccess,
        SiUnit unit,
        @Nullable String refersTo,
        @Nullable String initialFrom,
        double minimum,
        String doc) {
    /** Copies the access set; refuses fewer than one component. */
    public PropertyDescriptor {
        Objects.requireNonNull(name, "name");
        Objects.requireNonNull(kind, "kind");
        if (components < 1) {
            throw new IllegalArgumentException(
                    "property '" + name + "': " + components + " components, expected at least 1");
        }
        lawAccess = Set.copyOf(lawAccess);
    }

    /** A property whose values may be any that its type holds. */
    public PropertyDescriptor(
            String name,
            String kind,
            ScalarType type,
            int components,
            Set<Access> lawAccess,
            SiUnit unit,
            @Nullable String refersTo,
            @Nullable String initialFrom,
            String doc) {
        this(
                name,
                kind,
                type,
                components,
                lawAccess,
                unit,
                refersTo,
                initialFrom,
                Double.NEGATIVE_INFINITY,
                doc);
    }
}
