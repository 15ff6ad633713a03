// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.file.WorldFile;
import reve.core.file.WorldWriter;
import reve.core.frame.Pacing;
import reve.core.world.Item;
import reve.worlds.server.Simulation;

import java.nio.charset.StandardCharsets;

/** The hoist of {@code laws/rigid_contact/README.md}: a motor, a gear and a rope lift a crate. */
class HoistIT {
    private static final double G = 9.81;

    private static String hoist() throws Exception {
        return Document.read(Project.ROOT.resolve("laws/rigid_contact/README.md")).blocks().stream()
                .map(Document.Block::text)
                .filter(text -> text.contains("name: hoist\n"))
                .findFirst()
                .orElseThrow();
    }

    private static Item item(Simulation simulation, String name) {
        return simulation.world().find(name).orElseThrow();
    }

    @Test
    void theDrumLiftsTheCrateByItsRadiusPerAngle() throws Exception {
        var description = WorldFile.parse("w", hoist().getBytes(StandardCharsets.UTF_8));
        try (Simulation simulation = new Simulation(description, Pacing.FAST)) {
            simulation.loop().run(120);
            double before = item(simulation, "crate").physical().location()[1];
            simulation.loop().run(120);
            double[] crate = item(simulation, "crate").physical().location();
            assertThat(crate[1] - before).isCloseTo(2 * 0.5 * 0.3, within(2e-3));
            assertThat(item(simulation, "axle").physics().scalar("jointAngle"))
                    .isCloseTo(4 * 0.5, within(0.02));
            assertThat(item(simulation, "winding").physics().scalar("gearForce"))
                    .isCloseTo(15 * G, within(0.5));
            assertThat((Double) item(simulation, "winding").semantic().get("load").orElseThrow())
                    .isCloseTo(15 * G, within(0.5));
            assertThat(item(simulation, "sling").physics().vector("jointForce")[1])
                    .isCloseTo(10 * G, within(0.5));
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    /** A saved world contains the whole state of ropes and gears, also turns beyond 180°. */
    @Test
    void aSavedHoistContinuesWithTheSameBits() throws Exception {
        String fast = hoist().replace("0.5 rad/s", "4 rad/s");
        var description = WorldFile.parse("w", fast.getBytes(StandardCharsets.UTF_8));
        try (Simulation simulation = new Simulation(description, Pacing.FAST)) {
            simulation.loop().run(90);
            assertThat(item(simulation, "winding").physics().vector("gearPlaces")[1])
                    .isGreaterThan(Math.PI);
            String saved = WorldWriter.write(simulation.descriptionNow());
            simulation.loop().run(60);
            var again = WorldFile.parse("w", saved.getBytes(StandardCharsets.UTF_8));
            try (Simulation continued = new Simulation(again, Pacing.FAST)) {
                continued.loop().run(60);
                for (String body : new String[] {"drum", "hook", "crate"}) {
                    assertThat(item(continued, body).physical().location())
                            .as(body)
                            .containsExactly(item(simulation, body).physical().location());
                }
            }
        }
    }
}
