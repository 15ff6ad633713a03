// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.List;
import java.util.Optional;

/**
 * The contract of one use of an engine: which properties exist. The engine copies it; types and
 * units never change after that.
 *
 * @param realType F32 or F64: which variant of each law is used
 * @param timeUnit unit of {@code dt}
 */
public record Prototype(
        String name, ScalarType realType, SiUnit timeUnit, List<PropertyDescriptor> properties) {
    /** Copies the list. */
    public Prototype {
        properties = List.copyOf(properties);
    }

    /** The property of that name. */
    public Optional<PropertyDescriptor> find(String property) {
        return properties.stream().filter(p -> p.name().equals(property)).findFirst();
    }
}
