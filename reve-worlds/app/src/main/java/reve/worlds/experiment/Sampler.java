// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.Measure;
import reve.core.file.RunPlan;
import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.frame.Timing;
import reve.core.rule.Bindings;
import reve.core.rule.EvaluationException;
import reve.core.text.Suggestion;
import reve.core.world.Item;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.pe.LedgerLine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.worlds.server.Simulation;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.stream.Stream;

/**
 * Listener that measures a run in the phase PUBLISH. It measures frame 0, every n-th frame, and the
 * last frame. For the world's thread only.
 */
final class Sampler implements FrameListener {
    private static final List<String> LINES = List.of("client", "ground", "unloaded", "total");

    private final Simulation simulation;
    private final RunPlan plan;
    private final OptionalInt every;
    private final Timing timing;
    private final List<Reading> readings = new ArrayList<>();
    private final List<Sample> samples = new ArrayList<>();
    private final Map<String, String> notes = new LinkedHashMap<>();
    private List<LedgerLine> ledger = List.of();

    /**
     * A measure, with the bindings (values of names) of its expression if the measure has an
     * expression.
     */
    private record Reading(Measure measure, Optional<Bindings> bindings) {}

    /** The reason why a measure has no value. */
    private static final class NoValue extends Exception {
        private static final long serialVersionUID = 1;

        NoValue(String message) {
            super(message);
        }
    }

    /**
     * Opens the ledger if a measure needs it.
     *
     * @throws PhysicsException if a measure names a line that the ledger will not have
     */
    Sampler(Simulation simulation, RunPlan plan, OptionalInt every) {
        this.simulation = simulation;
        this.plan = plan;
        this.every = every;
        this.timing = plan.world().timing();
        boolean open = false;
        for (Measure measure : plan.measures()) {
            readings.add(
                    new Reading(
                            measure,
                            switch (measure.source()) {
                                case Measure.OfItem of -> Optional.of(of.expression().bindings());
                                case Measure.OfKind of -> Optional.of(of.expression().bindings());
                                case Measure.OfLedger of -> Optional.empty();
                                case Measure.Energy energy -> Optional.empty();
                            }));
            if (measure.source() instanceof Measure.OfLedger of) {
                requireLine(measure, of.line());
            }
            open |= needsLedger(measure);
        }
        if (open) {
            simulation.physics().setLedger(true);
        }
    }

    private static boolean needsLedger(Measure measure) {
        return measure.source() instanceof Measure.OfLedger
                || measure.source() instanceof Measure.Energy energy
                        && energy.part() != Measure.EnergyPart.KINETIC;
    }

    private void requireLine(Measure measure, String line) {
        List<String> known =
                Stream.concat(
                                simulation.physics().laws().loaded().stream().map(PhysicsLaw::name),
                                LINES.stream())
                        .toList();
        if (!known.contains(line) && plan.steps().isEmpty()) {
            throw new IllegalArgumentException(
                    measure.place()
                            + ": ledger: there is no line `"
                            + line
                            + "`, expected a law or one of "
                            + String.join(", ", LINES)
                            + Suggestion.of(line, known));
        }
    }

    @Override
    public void onFrame(FrameEvent frame) {
        long number = frame.frame();
        boolean due = every.isPresent() && number % every.getAsInt() == 0;
        if (due || number == plan.frames()) {
            sample(number, frame.world());
        }
    }

    private void sample(long frame, World world) {
        if (plan.measures().stream().anyMatch(Sampler::needsLedger)) {
            ledger = simulation.physics().ledger();
        }
        List<Optional<Object>> values = new ArrayList<>();
        for (Reading reading : readings) {
            Measure measure = reading.measure;
            Optional<Object> value;
            try {
                value = Optional.of(value(reading, world));
            } catch (EvaluationException | NoValue none) {
                value = Optional.empty();
                notes.putIfAbsent(
                        measure.name(),
                        measure.name()
                                + " has no value in frame "
                                + frame
                                + ": "
                                + none.getMessage());
            }
            values.add(value);
        }
        samples.add(new Sample(frame, timing.timeSeconds(frame), values));
    }

    private Object value(Reading reading, World world) throws EvaluationException, NoValue {
        return switch (reading.measure.source()) {
            case Measure.OfItem of -> {
                Item item =
                        world.find(of.item())
                                .orElseThrow(
                                        () -> new NoValue("the world has no item " + of.item()));
                yield of.expression().evaluate(reading.bindings.orElseThrow().of(item));
            }
            case Measure.OfKind of -> folded(of, reading.bindings.orElseThrow(), world);
            case Measure.OfLedger of -> ledgerValue(of);
            case Measure.Energy energy -> energy(energy.part(), world);
        };
    }

    private static double folded(Measure.OfKind of, Bindings bindings, World world)
            throws EvaluationException, NoValue {
        double sum = 0;
        double least = Double.POSITIVE_INFINITY;
        double greatest = Double.NEGATIVE_INFINITY;
        int count = 0;
        for (Item item : world.items()) {
            if (item.kind().equals(of.kind())
                    && (of.itemClass().isEmpty() || item.semantic().isA(of.itemClass().get()))
                    && (!item.physics().isEmpty() || !readsPhysics(of))) {
                double value = of.expression().numbers(bindings.of(item), 1)[0];
                sum += value;
                least = Math.min(least, value);
                greatest = Math.max(greatest, value);
                count++;
            }
        }
        if (count == 0 && of.fold() != Measure.Fold.SUM) {
            throw new NoValue("there is no such item");
        }
        return switch (of.fold()) {
            case SUM -> sum;
            case MEAN -> sum / count;
            case MIN -> least;
            case MAX -> greatest;
        };
    }

    private static boolean readsPhysics(Measure.OfKind of) {
        return of.expression().roots().contains("physics");
    }

    private Object ledgerValue(Measure.OfLedger of) throws NoValue {
        LedgerLine line =
                ledger.stream()
                        .filter(each -> each.name().equals(of.line()))
                        .findFirst()
                        .orElseThrow(
                                () -> new NoValue("the ledger has no line " + of.line() + " now"));
        return switch (of.value()) {
            case MOMENTUM -> line.momentum();
            case ANGULAR_MOMENTUM -> line.angularMomentum();
            case ENERGY -> line.energy();
            case POTENTIAL_ENERGY -> line.potentialEnergy();
            case POTENTIAL_CHANGE -> line.potentialChange();
            case ENERGY_BALANCE -> line.energyBalance();
        };
    }

    private double energy(Measure.EnergyPart part, World world) {
        double potential =
                part == Measure.EnergyPart.KINETIC
                        ? 0
                        : ledger.stream()
                                .filter(LedgerLine::law)
                                .mapToDouble(LedgerLine::potentialEnergy)
                                .reduce(0, Double::sum);
        return part == Measure.EnergyPart.POTENTIAL ? potential : potential + kinetic(world);
    }

    /** Returns the kinetic energy of translation and rotation of all bodies [J]. */
    private static double kinetic(World world) {
        double sum = 0;
        for (Item item : world.items()) {
            if (item.kind().equals(WorldPrototype.BODY) && !item.physics().isEmpty()) {
                double[] v = item.physics().vector("velocity");
                double[] i = item.physics().vector("inertia");
                double[] w =
                        inBody(
                                item.physical().orientation(),
                                item.physics().vector("angularVelocity"));
                sum += 0.5 * item.physics().scalar("mass") * dot(v, v);
                sum += 0.5 * (i[0] * w[0] * w[0] + i[1] * w[1] * w[1] + i[2] * w[2] * w[2]);
            }
        }
        return sum;
    }

    private static double dot(double[] a, double[] b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }

    /** Returns the components of a vector along the axes of a body with this orientation. */
    private static double[] inBody(double[] q, double[] v) {
        double[] axis = {-q[0], -q[1], -q[2]};
        double[] t = cross(axis, v);
        double[] u = cross(axis, t);
        double[] turned = new double[3];
        for (int k = 0; k < 3; k++) {
            turned[k] = v[k] + 2 * (q[3] * t[k] + u[k]);
        }
        return turned;
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }

    /** Returns the measurements so far. */
    List<Sample> samples() {
        return List.copyOf(samples);
    }

    /** Returns the reasons why measures had no value, one note for each measure. */
    List<String> notes() {
        return List.copyOf(notes.values());
    }
}
