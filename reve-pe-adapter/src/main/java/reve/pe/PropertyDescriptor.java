// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import org.jspecify.annotations.Nullable;

import java.util.Objects;
import java.util.Set;

/**
 * The declaration of one property of a prototype.
 *
 * @param name unique within the prototype, at most 47 bytes of UTF-8
 * @param kind kind of items, for example "body"; all properties of a kind have the same number of
 *     rows
 * @param components values per row, at least 1
 * @param lawAccess maximum access that a law may request
 * @param refersTo kind whose rows this U32 property's values refer to, or null
 * @param initialFrom for accumulators: the property of the same kind, type and unit from whose
 *     values each sum starts, or null if sums start from zero
 * @param minimum minimum value in the client's arrays [unit], for reals that laws only read;
 *     negative infinity for none
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

    /** Creates a property without a minimum value. */
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
