// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.Set;

/**
 * A property as it is bound in an engine.
 *
 * @param components values per row
 * @param lawAccess the most that any law may ask for
 * @param rowCount rows that laws see
 * @param version raised when the client touched or rebound the property
 */
public record PhysicalProperty(
        String name,
        String kind,
        ScalarType type,
        int components,
        Set<Access> lawAccess,
        long rowCount,
        long version) {
    /** Copies the access set. */
    public PhysicalProperty {
        lawAccess = Set.copyOf(lawAccess);
    }
}
