// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.util.List;

/**
 * The complete physics state of a world besides the world's own columns.
 *
 * @param libraries loaded libraries, in the order of loading
 * @param quarantined libraries that failed and stay unloaded
 * @param engineState from {@link reve.pe.PhysicsEngine#saveState}
 */
public record PhysicsImage(
        List<LawLibrary> libraries, List<Quarantined> quarantined, byte[] engineState) {
    /** Copies the lists. */
    public PhysicsImage {
        libraries = List.copyOf(libraries);
        quarantined = List.copyOf(quarantined);
    }
}
