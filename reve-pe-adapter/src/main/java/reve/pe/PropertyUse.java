// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.Set;

/**
 * The use of a property by one law.
 *
 * @param components values per row
 * @param optional true if the law also runs in a world without the property
 */
public record PropertyUse(
        String name,
        String kind,
        ScalarType type,
        int components,
        Set<Access> access,
        SiUnit unit,
        boolean optional) {
    /** Copies the access set. */
    public PropertyUse {
        access = Set.copyOf(access);
    }
}
