// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.pe.LedgerLine;
import reve.pe.adapter.PhysicsAdapter;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The ledger of energy and momentum of a served world. It is open only while clients ask for it.
 * For the world's thread, between frames.
 */
final class Ledger {
    private final PhysicsAdapter physics;
    private boolean open;

    Ledger(PhysicsAdapter physics) {
        this.physics = physics;
    }

    /**
     * Opens, restarts or closes the ledger, and returns its lines.
     *
     * @param change true opens or restarts it, false closes it
     */
    Map<String, Object> report(Optional<Boolean> change) {
        if (change.isPresent()) {
            physics.setLedger(change.get());
            open = change.get();
        }
        Map<String, Object> content = new LinkedHashMap<>();
        content.put("open", open);
        content.put(
                "lines",
                open ? physics.ledger().stream().map(Ledger::line).toList() : List.<Object>of());
        return content;
    }

    private static Map<String, Object> line(LedgerLine line) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("name", line.name());
        fields.put("law", line.law());
        fields.put("momentum", line.momentum());
        fields.put("angularMomentum", line.angularMomentum());
        fields.put("energy", line.energy());
        if (line.hasPotentialEnergy()) {
            fields.put("potentialEnergy", line.potentialEnergy());
            fields.put("potentialChange", line.potentialChange());
        }
        return fields;
    }
}
