// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The fastest oscillation of bodies that springs join, at their positions in the world file.
 * Springs act along their directions; springs without a direction are ignored. The estimate is the
 * largest eigenvalue of M^-1/2 (dt² K + 2 dt C) M^-1/2, with the length of a step dt and the
 * matrices of mass M, stiffness K and damping C. Power iteration computes the eigenvalue and
 * approaches it from below.
 */
final class SpringNetwork {
    private static final int ITERATIONS = 60;

    /**
     * The fastest oscillation.
     *
     * @param stiffness the eigenvalue (ω dt)² + 2 γ dt, see {@link StepChecks}
     * @param seconds length of a step at which the eigenvalue would be 1 [s]
     * @param spring the spring with the largest share in this oscillation
     */
    record Stiffest(double stiffness, double seconds, ItemFacts.Entry spring) {}

    private final List<ItemFacts.Entry> springs = new ArrayList<>();
    private final List<int[]> ends = new ArrayList<>();
    private final List<double[]> directions = new ArrayList<>();
    private final List<Double> strengths = new ArrayList<>();
    private final List<Double> inverseRoots = new ArrayList<>();
    private final Map<String, Integer> rows = new HashMap<>();
    private final double dt;

    private SpringNetwork(double dt) {
        this.dt = dt;
    }

    /** Returns the fastest oscillation; empty if no spring acts on a movable body. */
    static Optional<Stiffest> stiffest(ItemFacts items, double dt) {
        var network = new SpringNetwork(dt);
        for (ItemFacts.Entry entry : items.all()) {
            if (entry.item().kind().equals("spring")) {
                network.add(entry, items);
            }
        }
        return network.springs.isEmpty() ? Optional.empty() : Optional.of(network.iterate());
    }

    private void add(ItemFacts.Entry spring, ItemFacts items) {
        Optional<ItemFacts.Entry> one = end(spring, "end1", items);
        Optional<ItemFacts.Entry> other = end(spring, "end2", items);
        double strength =
                spring.number("springConstant") * dt * dt
                        + 2 * spring.number("dampingConstant") * dt;
        if (one.isEmpty()
                || other.isEmpty()
                || !(strength > 0)
                || !one.get().isMovable() && !other.get().isMovable()) {
            return;
        }
        double[] from = one.get().item().location();
        double[] to = other.get().item().location();
        double length = 0;
        for (int axis = 0; axis < 3; axis++) {
            to[axis] -= from[axis];
            length += to[axis] * to[axis];
        }
        length = Math.sqrt(length);
        if (!(length > 0)
                || one.get().item().parent().isPresent()
                || other.get().item().parent().isPresent()) {
            return;
        }
        for (int axis = 0; axis < 3; axis++) {
            to[axis] /= length;
        }
        springs.add(spring);
        ends.add(new int[] {row(one.get()), row(other.get())});
        directions.add(to);
        strengths.add(strength);
    }

    private static Optional<ItemFacts.Entry> end(
            ItemFacts.Entry spring, String reference, ItemFacts items) {
        return Optional.ofNullable(spring.item().references().get(reference))
                .flatMap(names -> items.find(names.getFirst()));
    }

    private int row(ItemFacts.Entry body) {
        return rows.computeIfAbsent(
                body.name(),
                _ -> {
                    inverseRoots.add(body.isMovable() ? 1 / Math.sqrt(body.mass()) : 0);
                    return inverseRoots.size() - 1;
                });
    }

    private Stiffest iterate() {
        double[] now = new double[3 * inverseRoots.size()];
        for (int i = 0; i < now.length; i++) {
            // No symmetry of the network makes this start vector orthogonal to the result.
            now[i] = 1 + StrictMath.sin(1.0 + 7.0 * i);
        }
        normalise(now);
        double[] next = new double[now.length];
        double[] part = new double[springs.size()];
        double stiffness = 0;
        for (int iteration = 0; iteration < ITERATIONS; iteration++) {
            stiffness = multiply(now, next, part);
            if (!(normalise(next) > 0)) {
                break;
            }
            double[] swap = now;
            now = next;
            next = swap;
        }
        stiffness = multiply(now, next, part);
        int most = 0;
        for (int i = 1; i < part.length; i++) {
            if (part[i] > part[most]) {
                most = i;
            }
        }
        return new Stiffest(stiffness, step(part), springs.get(most));
    }

    /** Returns the length t of a step [s] for which ω² t² + 2 γ t = 1. */
    private double step(double[] part) {
        double square = 0;
        double linear = 0;
        for (int spring = 0; spring < part.length; spring++) {
            double damping =
                    part[spring]
                            * 2
                            * springs.get(spring).number("dampingConstant")
                            * dt
                            / strengths.get(spring);
            linear += damping / dt;
            square += (part[spring] - damping) / (dt * dt);
        }
        return 2 / (linear + Math.sqrt(linear * linear + 4 * square));
    }

    /**
     * Computes the product {@code next} of the matrix A and the vector {@code now}, and the
     * contribution of each spring to {@code now}·A·{@code now}. Returns the sum of these
     * contributions.
     */
    private double multiply(double[] now, double[] next, double[] part) {
        Arrays.fill(next, 0);
        double sum = 0;
        for (int spring = 0; spring < part.length; spring++) {
            int[] end = ends.get(spring);
            double[] direction = directions.get(spring);
            double one = inverseRoots.get(end[0]);
            double other = inverseRoots.get(end[1]);
            double stretch = 0;
            for (int axis = 0; axis < 3; axis++) {
                stretch +=
                        direction[axis]
                                * (now[3 * end[1] + axis] * other - now[3 * end[0] + axis] * one);
            }
            double force = strengths.get(spring) * stretch;
            for (int axis = 0; axis < 3; axis++) {
                next[3 * end[0] + axis] -= one * force * direction[axis];
                next[3 * end[1] + axis] += other * force * direction[axis];
            }
            part[spring] = force * stretch;
            sum += part[spring];
        }
        return sum;
    }

    private static double normalise(double[] vector) {
        double sum = 0;
        for (double value : vector) {
            sum += value * value;
        }
        double length = Math.sqrt(sum);
        if (length > 0) {
            for (int i = 0; i < vector.length; i++) {
                vector[i] /= length;
            }
        }
        return length;
    }
}
