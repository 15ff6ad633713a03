// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter.Numeral;
import reve.core.urdf.RobotModel.Surface;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/**
 * Layers of the law {@code rigid_contact} for the types and affinities of MJCF. Bodies with the
 * same type and affinity are in one layer. The scenery is in layer 0.
 */
final class TouchLayers {
    private static final int MOST = 32;
    private final List<Surface> layers = new ArrayList<>();
    private final boolean hasFriction;

    /**
     * @param notes receives a line if the layers cannot express a combination in the file
     */
    TouchLayers(List<Surface> scenery, List<Surface> bodies, List<String> notes) {
        hasFriction = !bodies.isEmpty();
        layers.add(scenery.isEmpty() ? Surface.DEFAULT : scenery.getFirst());
        if (scenery.stream().anyMatch(surface -> !surface.equals(layers.getFirst()))) {
            notes.add(
                    "the immovable shapes differ in contype, conaffinity or friction; those of the"
                            + " first shape are used for all");
        }
        for (Surface surface : bodies) {
            if (layer(surface) < 0 && layers.size() < MOST) {
                layers.add(surface);
            } else if (layer(surface) < 0) {
                notes.add(
                        "the bodies have more than 32 combinations of contype and conaffinity;"
                                + " further bodies collide like the scenery");
                return;
            }
        }
    }

    /** Sets the contact properties of a body with this surface. */
    void put(Surface surface, Map<String, Object> physics) {
        int layer = Math.max(layer(surface), 0);
        List<Numeral> passes = new ArrayList<>();
        for (int other = 0; other < layers.size(); other++) {
            if (!layers.get(other).touches(surface)) {
                passes.add(Numeral.of(other));
            }
        }
        if (layer > 0) {
            physics.put("touchLayer", Numeral.of(layer));
        }
        if (!passes.isEmpty()) {
            physics.put("passesLayers", passes);
        }
        physics.put("friction", Numeral.of(surface.friction()));
        if (surface.spinning() > 0) {
            physics.put("spinFriction", Numeral.of(surface.spinning()));
        }
        if (surface.rolling() > 0) {
            physics.put("rollingFriction", Numeral.of(surface.rolling()));
        }
    }

    /** Returns whether the bodies have coefficients of friction. */
    boolean hasFriction() {
        return hasFriction;
    }

    private int layer(Surface surface) {
        for (int layer = 0; layer < layers.size(); layer++) {
            Surface other = layers.get(layer);
            if (other.type() == surface.type() && other.affinity() == surface.affinity()) {
                return layer;
            }
        }
        return -1;
    }
}
