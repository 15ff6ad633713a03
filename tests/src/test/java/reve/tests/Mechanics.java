// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import reve.core.file.LawReference;
import reve.core.world.Item;
import reve.core.world.WorldPrototype;
import reve.worlds.server.Simulation;

import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Conserved quantities of a running world's point masses and springs [SI units]. Each state counts
 * the items that exist at its time, because a level of an item may add or remove items.
 */
final class Mechanics {
    private final Simulation simulation;
    private final double[] gravity;
    private final double gravitationalConstant;
    private final double softening;

    /**
     * @param positions of all bodies by name, scenery too
     * @param immovable the positions of all bodies with mass 0, by name
     * @param kineticEnergy of motion in the world's frame
     * @param energy of motion (in the centre-of-mass frame, unless something holds the world in
     *     place), springs, uniform gravity and gravitation
     */
    record State(
            Map<String, double[]> positions,
            Map<String, List<Double>> immovable,
            double[] momentum,
            double kineticEnergy,
            double energy) {
        double[] position(String item) {
            return positions.get(item);
        }
    }

    Mechanics(Simulation simulation) {
        this.simulation = simulation;
        Item world = simulation.world().find(WorldPrototype.WORLD).orElseThrow();
        gravity = has("gravity_field") ? world.physics().vector("gravity") : new double[3];
        boolean attracts =
                has("newton_gravitation") || has("opencl_gravitation") || has("opencl_nbody");
        gravitationalConstant = attracts ? world.physics().scalar("gravitationalConstant") : 0;
        softening = world.physics().scalar("softening");
    }

    private boolean has(String law) {
        return simulation.description().laws().stream()
                .map(LawReference::name)
                .anyMatch(law::equals);
    }

    /** Returns the items of a kind that laws act on now. */
    private List<Item> all(String kind) {
        return simulation.world().items().stream()
                .filter(item -> item.kind().equals(kind) && !item.physics().isEmpty())
                .toList();
    }

    State state() {
        List<Item> bodies = all(WorldPrototype.BODY);
        Map<String, double[]> positions = new HashMap<>();
        Map<String, List<Double>> immovable = new HashMap<>();
        double[] momentum = new double[3];
        double mass = 0;
        double kineticEnergy = 0;
        double energy = gravitationalConstant == 0 ? 0 : gravitation(bodies);
        for (Item body : bodies) {
            double m = body.physics().scalar("mass");
            double[] x = body.physical().location();
            double[] v = body.physics().vector("velocity");
            positions.put(body.name(), x);
            if (m == 0) {
                if (body.parent().isEmpty()) { // an attached body moves with its parent
                    immovable.put(body.name(), List.of(x[0], x[1], x[2]));
                }
                continue;
            }
            mass += m;
            kineticEnergy += 0.5 * m * dot(v, v);
            energy -= m * dot(gravity, x);
            for (int axis = 0; axis < 3; axis++) {
                momentum[axis] += m * v[axis];
            }
        }
        for (Item item : simulation.world().items()) {
            if (!item.physical().isEmpty()) {
                positions.putIfAbsent(item.name(), item.physical().location());
            }
        }
        for (Item spring : all(WorldPrototype.SPRING)) {
            double stretch =
                    norm(subtract(end(spring, "end2"), end(spring, "end1")))
                            - spring.physics().scalar("length");
            energy += 0.5 * spring.physics().scalar("springConstant") * stretch * stretch;
        }
        energy += kineticEnergy;
        if (immovable.isEmpty()) {
            energy -= 0.5 * dot(momentum, momentum) / mass;
        }
        return new State(positions, immovable, momentum, kineticEnergy, energy);
    }

    /** Returns the potential energy of all pairs of bodies [J], with the softening of Plummer. */
    private double gravitation(List<Item> bodies) {
        double[] mass =
                bodies.stream().mapToDouble(body -> body.physics().scalar("mass")).toArray();
        double[][] at =
                bodies.stream().map(body -> body.physical().location()).toArray(double[][]::new);
        double energy = 0;
        for (int i = 0; i < mass.length; i++) {
            for (int j = 0; j < i; j++) {
                double[] between = subtract(at[i], at[j]);
                energy -=
                        gravitationalConstant
                                * mass[i]
                                * mass[j]
                                / Math.sqrt(dot(between, between) + softening * softening);
            }
        }
        return energy;
    }

    /** Returns the mean X of the bodies whose symbol {@code class} is the given one [m]. */
    double meanX(String classSymbol) {
        return all(WorldPrototype.BODY).stream()
                .filter(body -> body.semantic().get("class").equals(Optional.of(classSymbol)))
                .mapToDouble(body -> body.physical().location()[0])
                .average()
                .orElseThrow();
    }

    private double[] end(Item spring, String reference) {
        return simulation.world().item(spring.physics().reference(reference)).physical().location();
    }

    static double[] subtract(double[] a, double[] b) {
        return new double[] {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    }

    static double dot(double[] a, double[] b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }

    static double norm(double[] v) {
        return Math.sqrt(dot(v, v));
    }

    static double degreesBetween(double[] a, double[] b) {
        return Math.toDegrees(Math.acos(dot(a, b) / (norm(a) * norm(b))));
    }
}
