// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.Subject;
import reve.core.world.Action;
import reve.core.world.Forces;
import reve.core.world.ItemDefinition;
import reve.core.world.Possible;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;

import java.util.HashSet;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Check of combinations of an item's values, for example of material and shape. Each single value
 * has already been checked.
 */
final class BodyCheck {
    /** Maximum absolute coordinate [m]. The limit keeps the cubes of distances finite. */
    static final double MAX_PLACE = 1e100;

    /**
     * Maximum duration of a force [s]. The limit keeps its number of frames exact at every frame
     * rate.
     */
    static final double MAX_FORCE_SECONDS = Forces.MAX_FRAMES / 10_000;

    private static final String MASS = "mass";

    private final Doubts doubts;
    private final Problems problems;

    /**
     * Nodes whose inertia was refused. The repetitions of an item share a node, so that they cause
     * only one message.
     */
    private final Set<String> refused = new HashSet<>();

    /**
     * Lists of actions that were checked, by identity. Several items may share a list. The value
     * contains one bit for each kind of item for which the list was checked. Items are of the same
     * kind if they agree in two properties: whether they are movable, and whether they have a
     * physics aspect.
     */
    private final Map<List<Action>, Integer> checked = new IdentityHashMap<>();

    BodyCheck(Doubts doubts, Problems problems) {
        this.doubts = doubts;
        this.problems = problems;
    }

    /**
     * Checks an item.
     *
     * @param node node of the item, or of its first repetition
     */
    void check(Node node, ItemDefinition item) {
        if (!item.kind().equals(WorldPrototype.BODY)) {
            return;
        }
        if (item.material().isPresent() && item.shape() == Shape.none()) {
            doubts.refuse(
                    find(node, "physical", "material"),
                    "material: the item has no `shape` "
                            + "that could show it; give it one, or leave the material out",
                    problems);
        }
        checkInertia(node, item);
        if (isFirstOfThese(item)) {
            checkActions(node, item);
        }
    }

    /**
     * Returns true if the actions of the item were not yet checked for an item with the same
     * properties. Items may share a list of actions.
     */
    private boolean isFirstOfThese(ItemDefinition item) {
        if (item.actions().isEmpty()) {
            return false;
        }
        int look = (moves(item) ? 1 : 2) << (item.hasPhysics() ? 2 : 0);
        int before = checked.getOrDefault(item.actions(), 0);
        checked.put(item.actions(), before | look);
        return (before & look) == 0;
    }

    private static boolean moves(ItemDefinition item) {
        return item.parent().isEmpty()
                && item.physics(MASS).filter(mass -> mass[0] > 0).isPresent();
    }

    private void checkActions(Node node, ItemDefinition item) {
        for (Action action : item.actions()) {
            if (action instanceof DeclaredAction declared) {
                checkEffects(
                        find(node, "access", action.name(), "effects"), declared.effects(), item);
            }
        }
    }

    /** Returns whether a place is within the limits. Records a problem if it is not. */
    void checkPlace(Node node, double[] metres) {
        for (double coordinate : metres) {
            if (!(Math.abs(coordinate) <= MAX_PLACE)) {
                doubts.refuse(
                        node,
                        node.label()
                                + ": "
                                + coordinate
                                + " m is farther than "
                                + MAX_PLACE
                                + " m from the origin; distances to it would not be numbers",
                        problems);
                return;
            }
        }
    }

    private void checkInertia(Node node, ItemDefinition item) {
        Optional<double[]> given = item.physics("inertia");
        if (given.isEmpty()) {
            return;
        }
        Optional<String> why = Possible.impossibleInertia(given.get());
        if (why.isPresent() && refused.add(node.file() + node.pointer())) {
            doubts.refuse(find(node, "physics", "inertia"), "inertia: " + why.get(), problems);
        }
    }

    private void checkEffects(Node nodes, List<Effect> effects, ItemDefinition item) {
        boolean moves = moves(item);
        boolean getsMass =
                effects.stream()
                        .anyMatch(
                                effect ->
                                        effect instanceof Effect.SetProperty
                                                && effect.changes().equals("physics." + MASS));
        for (int i = 0; i < effects.size(); i++) {
            Node node = nodes.get(i).orElse(nodes);
            Effect effect = effects.get(i);
            if (effect instanceof Effect.Force force && force.seconds() > MAX_FORCE_SECONDS) {
                Node time = node.get("for").orElse(node);
                doubts.refuse(
                        time,
                        "for: found "
                                + force.seconds()
                                + " s, expected at most "
                                + MAX_FORCE_SECONDS
                                + " s",
                        problems);
            }
            if (effect instanceof Effect.SetLocation place
                    && place.to() instanceof Operand.Numbers numbers) {
                checkPlace(node.get("to").orElse(node), numbers.values());
            }
            if ((effect instanceof Effect.Force || effect instanceof Effect.Impulse)
                    && !moves
                    && !getsMass
                    && item.hasPhysics()
                    && item.levels().isEmpty()
                    && effect.of().equals(Subject.ITEM)) {
                Node push = node.get("force").or(() -> node.get("impulse")).orElse(node);
                doubts.warn(
                        push,
                        push.label() + ": moves nothing as long as the item has " + "mass 0",
                        problems);
            }
        }
    }

    /** Returns the value under nested keys, or the innermost mapping that exists. */
    private static Node find(Node node, String... keys) {
        Node found = node;
        for (String key : keys) {
            Optional<Node> next = found.get(key);
            if (next.isEmpty()) {
                return found;
            }
            found = next.get();
        }
        return found;
    }
}
