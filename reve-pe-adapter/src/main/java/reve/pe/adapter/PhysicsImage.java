// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.util.List;

/**
 * Everything that makes a world's physics go on as it would, beside the world's own columns.
 *
 * @param libraries loaded, in the order of loading
 * @param quarantined what failed and stays out
 * @param engineState as {@link reve.pe.PhysicsEngine#saveState} gives it
 */
public record PhysicsImage(
        List<LawLibrary> libraries, List<Quarantined> quarantined, byte[] engineState) {
    /** Copies the lists. */
    public PhysicsImage {
        libraries = List.copyOf(libraries);
        quarantined = List.copyOf(quarantined);
    }
}
