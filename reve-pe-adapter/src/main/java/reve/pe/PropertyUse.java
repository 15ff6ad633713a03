// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.Set;

/**
 * A property as one law uses it.
 *
 * @param components values per row
 * @param optional true if the law also runs without the property
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
