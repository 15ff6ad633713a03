// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * What is symbolic about an item beside name, symbols and attachment: much the same for many items,
 * which then share it. Immutable.
 *
 * @param material of the whole shape; without it, a mesh shows its own
 * @param actions what can be done with the item
 * @param capabilities what the item can do with others
 * @param sensors what an agent that has the item as its body perceives with; none for everything
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
