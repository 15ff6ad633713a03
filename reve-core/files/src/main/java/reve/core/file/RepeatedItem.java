// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Optional;

/**
 * The first repetition of an item. The other repetitions differ from it only in the values of
 * formulas. Therefore only these values are read for the other repetitions.
 *
 * @param node the node of the first repetition
 * @param definition the definition read from this node
 */
record RepeatedItem(Node node, ItemDefinition definition) {

    String kind() {
        return definition.kind();
    }

    /** Returns whether each value of a formula can be read without the rest of the item. */
    boolean differsInSingleValues(List<Template.Made> values) {
        return values.stream().allMatch(made -> isSingle(made.aspect(), made.value().key()));
    }

    private boolean isSingle(String aspect, String key) {
        return switch (aspect) {
            case "" -> key.equals("name") || key.equals("parent");
            case "physical" ->
                    key.equals("location") || key.equals("orientation") || key.equals("colour");
            case "semantic" -> true;
            case "physics" ->
                    !key.equals("density")
                            && !key.equals(WorldPrototype.SUBSTANCE)
                            && node.get("parent").isEmpty();
            default -> false;
        };
    }

    /**
     * Returns the name of another repetition.
     *
     * @param values the values of formulas in that repetition
     */
    Node name(List<Template.Made> values) {
        return find(values, "", "name").or(() -> node.get("name")).orElseThrow();
    }

    /**
     * Returns the parent of another repetition.
     *
     * @param values the values of formulas in that repetition
     */
    Optional<Node> parent(List<Template.Made> values) {
        return find(values, "", "parent").or(() -> node.get("parent"));
    }

    /**
     * Returns a physics property of another repetition.
     *
     * @param values the values of formulas in that repetition
     */
    Optional<Node> physics(List<Template.Made> values, String property) {
        return find(values, "physics", property)
                .or(() -> node.get("physics").flatMap(aspect -> aspect.get(property)));
    }

    private static Optional<Node> find(List<Template.Made> values, String aspect, String key) {
        for (Template.Made made : values) {
            if (made.aspect().equals(aspect) && made.value().key().equals(key)) {
                return Optional.of(made.value());
            }
        }
        return Optional.empty();
    }
}
