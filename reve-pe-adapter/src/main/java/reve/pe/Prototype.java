// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.List;
import java.util.Optional;

/**
 * The set of properties of an engine. The engine copies it; types and units never change
 * afterwards.
 *
 * @param realType F32 or F64; the floating-point type in which all laws compute
 * @param timeUnit unit of {@code dt}
 */
public record Prototype(
        String name, ScalarType realType, SiUnit timeUnit, List<PropertyDescriptor> properties) {
    /** Copies the list. */
    public Prototype {
        properties = List.copyOf(properties);
    }

    /** Returns the property with a name. */
    public Optional<PropertyDescriptor> find(String property) {
        return properties.stream().filter(p -> p.name().equals(property)).findFirst();
    }
}
