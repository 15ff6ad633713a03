// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.Set;

/**
 * A property together with its array in an engine.
 *
 * @param components values per row
 * @param lawAccess maximum access of any law
 * @param rowCount number of rows that laws see
 * @param version increases with each {@link PhysicalPropertyProvider#touch} or rebind
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
