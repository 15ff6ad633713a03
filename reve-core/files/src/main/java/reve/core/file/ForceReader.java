// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;
import reve.core.world.ScalarType;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.stream.Collectors;

/**
 * Reader of the forces that act from the start of a world. A file that was saved from a running
 * world may contain them. Runs after all items were read.
 */
final class ForceReader {
    private static final Unit NEWTON = Unit.parse("N");

    private final ItemMentions names;
    private final List<ItemDefinition> items;
    private final ScalarType real;
    private final PhysicsReader physics;
    private final Doubts doubts;
    private final Problems problems;
    private final Quantities quantities;

    /**
     * @param items the valid items of the file
     */
    ForceReader(
            ItemMentions names,
            List<ItemDefinition> items,
            PhysicsReader physics,
            Doubts doubts,
            Problems problems) {
        this.physics = physics;
        this.names = names;
        this.items = items;
        this.real = physics.prototype().realType();
        this.doubts = doubts;
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /** Returns the valid forces, in the order of the file. */
    List<LastingForce> readAll(Node list) {
        List<LastingForce> forces = new ArrayList<>();
        Set<String> immovable =
                items.stream()
                        .filter(ForceReader::isImmovable)
                        .map(ItemDefinition::name)
                        .collect(Collectors.toSet());
        for (Node node : list.children()) {
            if (problems.full()) {
                break;
            }
            Optional<String> item = node.get("item").flatMap(names::physicalBody);
            Optional<double[]> newtons = node.get("force").flatMap(this::newtons);
            Optional<Double> frames = node.get("frames").flatMap(Node::number);
            item.filter(immovable::contains)
                    .ifPresent(
                            name ->
                                    doubts.refuse(
                                            node.get("item").orElseThrow(),
                                            "item: `"
                                                    + Node.shorten(name)
                                                    + "` has mass 0, so no force moves it; give it"
                                                    + " a mass, or leave the force out",
                                            problems));
            if (item.isPresent() && newtons.isPresent() && frames.isPresent()) {
                forces.add(
                        new LastingForce(
                                item.get(),
                                Arrays.stream(newtons.get()).boxed().toList(),
                                frames.get().longValue()));
            }
        }
        return forces;
    }

    private static boolean isImmovable(ItemDefinition item) {
        return item.physics("mass").filter(mass -> mass[0] > 0).isEmpty();
    }

    private Optional<double[]> newtons(Node force) {
        return quantities
                .numbers(force, 3, NEWTON)
                .filter(
                        newtons -> {
                            boolean fits = Arrays.stream(newtons).allMatch(real::holds);
                            if (!fits) {
                                problems.add(
                                        force,
                                        "force: "
                                                + Arrays.toString(newtons)
                                                + " N is not within the range of a 32-bit real; use"
                                                + " prototype si-f64");
                            }
                            return fits && physics.isWorkable(force, newtons);
                        });
    }
}
