// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * The symbolic data of an item except name, symbols and attachment. Many items are equal in these
 * data and share one object. Immutable.
 *
 * @param material material of the whole shape; if empty, a mesh keeps the materials of its file
 * @param look appearance of a spring or surface
 * @param actions actions that agents can perform on the item
 * @param capabilities capabilities of the item as the body of an agent
 * @param sensors sensors for an agent with this item as its body; if empty, the agent perceives
 *     everything
 * @param voice voice of an agent with this item as its body; empty if the agent cannot speak
 * @param levels several physical descriptions of the item; empty for most items
 */
public record Likeness(
        String kind,
        Shape shape,
        Optional<Material> material,
        ConnectionLook look,
        List<Action> actions,
        List<String> capabilities,
        List<Sensor> sensors,
        Optional<Voice> voice,
        List<Level> levels) {

    static Likeness of(ItemDefinition definition) {
        return new Likeness(
                definition.kind(),
                definition.shape(),
                definition.material(),
                definition.look(),
                definition.actions(),
                definition.capabilities(),
                definition.sensors(),
                definition.voice(),
                definition.levels());
    }

    Likeness with(Shape newShape) {
        return new Likeness(
                kind, newShape, material, look, actions, capabilities, sensors, voice, levels);
    }

    Likeness with(Optional<Material> newMaterial) {
        return new Likeness(
                kind, shape, newMaterial, look, actions, capabilities, sensors, voice, levels);
    }

    Likeness with(ConnectionLook newLook) {
        return new Likeness(
                kind, shape, material, newLook, actions, capabilities, sensors, voice, levels);
    }

    Likeness with(List<Action> newActions) {
        return new Likeness(
                kind, shape, material, look, newActions, capabilities, sensors, voice, levels);
    }
}
