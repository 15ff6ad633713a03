// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * The symbolic data of an item except name, symbols and attachment. Often equal for many items,
 * which then share it. Immutable.
 *
 * @param material of the whole shape; without it, a mesh has its own materials
 * @param actions on the item
 * @param capabilities of the item
 * @param sensors for an agent with this item as its body; if empty, the agent perceives everything
 */
public record Likeness(
        String kind,
        Shape shape,
        Optional<Material> material,
        List<Action> actions,
        List<String> capabilities,
        List<Sensor> sensors) {

    static Likeness of(ItemDefinition definition) {
        return new Likeness(
                definition.kind(),
                definition.shape(),
                definition.material(),
                definition.actions(),
                definition.capabilities(),
                definition.sensors());
    }

    Likeness with(Shape newShape) {
        return new Likeness(kind, newShape, material, actions, capabilities, sensors);
    }

    Likeness with(Optional<Material> newMaterial) {
        return new Likeness(kind, shape, newMaterial, actions, capabilities, sensors);
    }

    Likeness with(List<Action> newActions) {
        return new Likeness(kind, shape, material, newActions, capabilities, sensors);
    }
}
