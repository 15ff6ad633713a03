// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Item;
import reve.worlds.server.LawPath;
import reve.worlds.server.Simulation;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.function.ToDoubleFunction;
import java.util.stream.DoubleStream;
import java.util.stream.Stream;

/** The closed forms and invariants that docs/gallery.md states for the worlds in worlds/gallery. */
class GalleryIT {
    private static final Path GALLERY = Project.WORLDS.resolve("gallery");
    private static final int RATE = 60;

    @TempDir private Path folder;

    private static Simulation load(String name) throws Exception {
        Simulation simulation = open(GALLERY.resolve(name + ".yaml"));
        assertThat(simulation.warnings(true)).as(name).isEmpty();
        return simulation;
    }

    /** Loads a world of the gallery in which a text is replaced. */
    private Simulation load(String name, String text, String replacement) throws Exception {
        String world = Files.readString(GALLERY.resolve(name + ".yaml"));
        assertThat(world).contains(text);
        Path file = folder.resolve(name + ".yaml");
        Files.writeString(file, world.replace(text, replacement));
        Path laws = Files.createDirectories(folder.resolve("laws"));
        Path law = Path.of("laws", name + ".law");
        Files.copy(GALLERY.resolve(law), laws.resolve(law.getFileName()));
        return open(file);
    }

    private static Simulation open(Path file) throws Exception {
        LawPath laws = LawPath.ofShipped().forWorld(file.getParent());
        return new Simulation(WorldFile.load(file), Pacing.FAST, laws);
    }

    private static void run(Simulation simulation, double seconds) {
        simulation.loop().run(Math.round(seconds * RATE));
        assertThat(simulation.events().faults()).isEmpty();
    }

    private static double[] at(Simulation simulation, String item) {
        return simulation.world().find(item).orElseThrow().physical().location();
    }

    private static double value(Simulation simulation, String item, String property) {
        return simulation.world().find(item).orElseThrow().physics().scalar(property);
    }

    private static List<Item> items(Simulation simulation, String prefix) {
        return simulation.world().items().stream()
                .filter(item -> item.name().startsWith(prefix))
                .toList();
    }

    private static double sum(
            Simulation simulation, String prefix, ToDoubleFunction<Item> quantity) {
        return items(simulation, prefix).stream().mapToDouble(quantity).sum();
    }

    @Test
    void everyWorldHasALawAPictureAndASectionOfThePage() throws IOException {
        String page = Files.readString(Project.ROOT.resolve("docs/gallery.md"));
        try (Stream<Path> files = Files.list(GALLERY)) {
            List<String> names =
                    files.map(file -> file.getFileName().toString())
                            .filter(name -> name.endsWith(".yaml"))
                            .map(name -> name.replace(".yaml", ""))
                            .toList();
            assertThat(names).hasSize(10);
            for (String name : names) {
                assertThat(GALLERY.resolve("laws/" + name + ".law")).isRegularFile();
                assertThat(GALLERY.resolve(name + ".png")).isNotEmptyFile();
                String text = Files.readString(GALLERY.resolve("laws/" + name + ".law"));
                assertThat(page)
                        .contains("worlds/gallery/" + name + ".yaml")
                        .contains("](../worlds/gallery/" + name + ".png)")
                        .contains("```law\n" + text.lines().skip(1).toList().getFirst() + "\n");
            }
        }
    }

    /**
     * Two equal vortices at the distance d rotate about their middle with the angular velocity Γ /
     * (π d²).
     */
    @Test
    void vorticesCircleEachOther() throws Exception {
        try (Simulation simulation = load("vortex")) {
            run(simulation, 3);
            double angle = 0.5 * 3;
            double[] east = at(simulation, "east");
            double[] west = at(simulation, "west");
            // The scheme moves bodies along tangents, so the circle grows by ω² dt t / 2.
            assertThat(east[0]).isCloseTo(Math.cos(angle), within(1e-3));
            assertThat(east[1]).isCloseTo(Math.sin(angle), within(1e-3));
            assertThat(east[0] + west[0]).isCloseTo(0, within(1e-12));
            assertThat(east[1] + west[1]).isCloseTo(0, within(1e-12));
        }
    }

    /** Returns the energy of the atoms with the smooth cutoff of the law [J]. */
    private static double energy(Simulation simulation) {
        List<Item> atoms = items(simulation, "atom-");
        double energy = 0;
        for (int i = 0; i < atoms.size(); i++) {
            double[] v = atoms.get(i).physics().vector("velocity");
            energy += 0.5 * Mechanics.dot(v, v);
            for (int j = 0; j < i; j++) {
                double r =
                        Mechanics.norm(
                                Mechanics.subtract(
                                        atoms.get(i).physical().location(),
                                        atoms.get(j).physical().location()));
                double t = Math.max(0, (r - 2.25) / 0.25);
                double cut = 1 + t * t * t * (-10 + t * (15 - 6 * t));
                energy += r > 2.5 ? 0 : 4 * (Math.pow(r, -12) - Math.pow(r, -6)) * cut;
            }
        }
        return energy;
    }

    @Test
    void atomsKeepTheirEnergyUnlessTheyAreCooled() throws Exception {
        try (Simulation simulation =
                load(
                        "condensation",
                        "laws: [condensation,",
                        "laws: [{name: condensation, parameters: {cooling: 0}},")) {
            double before = energy(simulation);
            run(simulation, 3);
            assertThat(energy(simulation)).isCloseTo(before, within(2e-3 * Math.abs(before)));
        }
        try (Simulation simulation = load("condensation")) {
            assertThat(energy(simulation)).isGreaterThan(-75);
            run(simulation, 20);
            assertThat(energy(simulation)).isLessThan(-3 * 75);
        }
    }

    @Test
    void birdsFlyAtOneSpeedInOneDirection() throws Exception {
        try (Simulation simulation = load("boids")) {
            assertThat(order(simulation)).isLessThan(0.4);
            run(simulation, 8);
            assertThat(order(simulation)).isGreaterThan(0.95);
            for (Item bird : items(simulation, "bird-")) {
                assertThat(Mechanics.norm(bird.physics().vector("velocity")))
                        .isCloseTo(3, within(1.0));
            }
        }
    }

    /**
     * Returns the length of the mean direction of flight. It is 1 if all birds fly in one
     * direction.
     */
    private static double order(Simulation simulation) {
        double[] mean = new double[3];
        List<Item> birds = items(simulation, "bird-");
        for (Item bird : birds) {
            double[] v = bird.physics().vector("velocity");
            for (int axis = 0; axis < 3; axis++) {
                mean[axis] += v[axis] / Mechanics.norm(v) / birds.size();
            }
        }
        return Mechanics.norm(mean);
    }

    /**
     * The temperatures along the row are half a period of a cosine. They keep this shape and decay
     * exponentially.
     */
    @Test
    void heatDecaysAsTheLongestWave() throws Exception {
        try (Simulation simulation = load("heat")) {
            run(simulation, 20);
            double rate = 5.0 / 100 * (2 - 2 * Math.cos(Math.PI / 12));
            double left = Math.pow(1 - rate / RATE, 20 * RATE);
            for (int i = 0; i < 12; i++) {
                double expected = 300 + 100 * Math.cos(Math.PI * (i + 0.5) / 12) * left;
                assertThat(value(simulation, "body-" + i, "temperature"))
                        .isCloseTo(expected, within(1e-9));
            }
        }
    }

    /**
     * The water below the moon rests at the place at which the tidal force and the stiffness
     * balance.
     */
    @Test
    void tidesRiseOnBothSides() throws Exception {
        try (Simulation simulation =
                load("tides", "laws: [tides,", "laws: [{name: tides, parameters: {month: 1e9}},")) {
            run(simulation, 20);
            for (double side : new double[] {1, -1}) {
                double x = 2 * side;
                for (int i = 0; i < 100; i++) {
                    double here = Math.signum(10 - x) / ((10 - x) * (10 - x));
                    x = 2 * side + 120 * (here - 1.0 / 100) / 2;
                }
                double[] found = at(simulation, side > 0 ? "water-0" : "water-18");
                assertThat(found[0]).isCloseTo(x, within(1e-5));
                assertThat(Math.abs(found[0])).isGreaterThan(2.1);
            }
            assertThat(at(simulation, "water-9")[1]).isLessThan(2);
        }
    }

    /**
     * With Ω = S ω / m, the difference between the velocity and the drift rotates by Ω t. A charge
     * in two fields moves in the same way.
     */
    @Test
    void spinCarriesOrSinksABall() throws Exception {
        try (Simulation simulation = load("magnus")) {
            run(simulation, 1.5);
            for (String ball : List.of("backspin", "no-spin", "topspin")) {
                double spin =
                        simulation
                                .world()
                                .find(ball)
                                .orElseThrow()
                                .physics()
                                .vector("angularVelocity")[2];
                double[] expected = trochoid(0.03 * spin / 0.4, 1.5);
                assertThat(at(simulation, ball)[0]).isCloseTo(expected[0], within(0.01));
                assertThat(at(simulation, ball)[1]).isCloseTo(expected[1], within(0.01));
            }
            assertThat(at(simulation, "backspin")[1])
                    .isGreaterThan(at(simulation, "no-spin")[1] + 2);
        }
    }

    /**
     * Returns the place of a ball after a time. The ball was thrown with (15, 12) m/s, and v' = g +
     * Ω z × v.
     */
    private static double[] trochoid(double omega, double time) {
        double g = 9.81;
        if (omega == 0) {
            return new double[] {15 * time, 12 * time - g * time * time / 2};
        }
        // The velocity without the drift (g / Ω, 0) only rotates.
        double drift = g / omega;
        double u = 15 - drift;
        double s = Math.sin(omega * time) / omega;
        double c = (1 - Math.cos(omega * time)) / omega;
        return new double[] {drift * time + u * s - 12 * c, u * c + 12 * s};
    }

    /** For μ = 1, the limit cycle has the amplitude 2.00862 and the period 6.66329 s. */
    @Test
    void swingsEndOnOneCycle() throws Exception {
        try (Simulation simulation = load("van_der_pol")) {
            run(simulation, 40);
            double[] most = new double[7];
            double crossed = 0;
            double period = 0;
            double last = at(simulation, "swing-3")[0];
            for (int frame = 1; frame <= 15 * RATE; frame++) {
                simulation.loop().step();
                for (int i = 0; i < 7; i++) {
                    most[i] = Math.max(most[i], at(simulation, "swing-" + i)[0]);
                }
                double now = at(simulation, "swing-3")[0];
                if (last < 0 && now >= 0) {
                    double time = (frame - now / (now - last)) / RATE;
                    period = time - crossed;
                    crossed = time;
                }
                last = now;
            }
            assertThat(DoubleStream.of(most).boxed())
                    .allSatisfy(
                            amplitude -> assertThat(amplitude).isCloseTo(2.00862, within(1e-3)));
            assertThat(period).isCloseTo(6.66329, within(1e-3));
        }
    }

    /** Each population stays on its curve gain x - death ln x + hunt y - birth ln y. */
    @Test
    void populationsReturn() throws Exception {
        try (Simulation simulation = load("predator_prey")) {
            double[] before = curves(simulation);
            for (int quarter = 0; quarter < 4; quarter++) {
                run(simulation, 2);
                double[] now = curves(simulation);
                for (int i = 0; i < 8; i++) {
                    assertThat(now[i]).isCloseTo(before[i], within(3e-3));
                }
            }
            // At the equilibrium (2, 2) nothing changes.
            assertThat(value(simulation, "population-0", "prey")).isCloseTo(2, within(1e-12));
            assertThat(Math.abs(value(simulation, "population-7", "prey") - 4.1))
                    .isGreaterThan(0.1);
        }
    }

    private static double[] curves(Simulation simulation) {
        return items(simulation, "population-").stream()
                .mapToDouble(
                        item -> {
                            double x = item.physics().scalar("prey");
                            double y = item.physics().scalar("predators");
                            return 0.5 * x - Math.log(x) + 0.5 * y - Math.log(y);
                        })
                .toArray();
    }

    /** Without inflow and outflow, reaction and diffusion keep the sum of both substances. */
    @Test
    void substancesAreKeptAndFormAPattern() throws Exception {
        try (Simulation simulation =
                load(
                        "reaction_diffusion",
                        "laws: [reaction_diffusion]",
                        "laws: [{name: reaction_diffusion, parameters: {feed: 0, kill: 0}}]")) {
            double before = substance(simulation);
            run(simulation, 3);
            assertThat(substance(simulation)).isCloseTo(before, within(1e-9 * before));
            assertThat(value(simulation, "place-15-16", "v")).isNotEqualTo(0.25);
        }
        try (Simulation simulation = load("reaction_diffusion")) {
            run(simulation, 15);
            assertThat(value(simulation, "place-0-0", "u")).isCloseTo(1, within(1e-3));
            double most =
                    items(simulation, "place-").stream()
                            .mapToDouble(item -> item.physics().scalar("v"))
                            .max()
                            .orElseThrow();
            assertThat(most).isBetween(0.2, 0.6);
        }
    }

    private static double substance(Simulation simulation) {
        return sum(
                simulation,
                "place-",
                item -> item.physics().scalar("u") + item.physics().scalar("v"));
    }

    /**
     * A weight swings between the rest length of its spring and twice its equilibrium, or it breaks
     * the spring.
     */
    @Test
    void onlyTheHeaviestWeightBreaksItsSpring() throws Exception {
        double g = 9.81;
        double k = 50;
        double time = 1.1;
        try (Simulation simulation = load("breaking_spring")) {
            run(simulation, time);
            for (int i = 0; i < 3; i++) {
                double mass = 0.6 + 0.5 * i;
                double omega = Math.sqrt(k / mass);
                double rest = mass * g / k;
                double below = rest * (1 - Math.cos(omega * time));
                if (2 * rest > 0.5) {
                    double broken = Math.acos(1 - 0.5 / rest) / omega;
                    double speed = rest * omega * Math.sin(omega * broken);
                    double free = time - broken;
                    below = 0.5 + speed * free + g * free * free / 2;
                }
                assertThat(at(simulation, "weight-" + i)[1]).isCloseTo(-1 - below, within(0.01));
            }
            assertThat(at(simulation, "weight-2")[1]).isLessThan(-3);
        }
    }
}
