// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.worlds.server.Simulation;

import java.util.List;
import java.util.Map;

/** The actions of worlds/workshop, with the real engine and laws. */
class WorkshopIT {
    private static final double FRAME_SECONDS = 1 / 60.0;

    private final WorldDescription description;
    private final Simulation simulation;
    private final World world;

    WorkshopIT() throws Exception {
        description = WorldFile.load(Project.WORLDS.resolve("workshop/world.yaml"));
        simulation = new Simulation(description, Pacing.FAST);
        world = simulation.world();
        world.add(description.agents().template().orElseThrow().renamed("smith"));
        simulation.loop().step();
    }

    @AfterEach
    void close() {
        simulation.close();
    }

    private Item item(String name) {
        return world.find(name).orElseThrow();
    }

    private double[] velocity(String item) {
        return item(item).physics().vector("velocity");
    }

    private void act(String item, String action, Map<String, ?> arguments) throws ActionRefused {
        Action found = item(item).access().find(action).orElseThrow();
        new ActionCall(
                        world,
                        simulation.loop().frame() + 1,
                        item(item),
                        world.find("smith"),
                        Arguments.check(found, arguments))
                .perform(found);
    }

    @Test
    void propertyThatAnActionSetsReachesTheLawsInTheNextFrame() throws Exception {
        simulation.loop().run(30);
        assertThat(velocity("weight")[1]).isCloseTo(0, within(1e-12));

        act("weight", "cut", Map.of());
        simulation.loop().step();

        assertThat(velocity("weight")[1]).isCloseTo(-9.81 * FRAME_SECONDS, within(1e-12));
    }

    @Test
    void forceOfAnActionActsForItsTimeAndNoLonger() throws Exception {
        act("weight", "pull", Map.of("force", List.of(10, 0, 0)));
        simulation.loop().run(30);
        double[] pulled = velocity("weight");
        simulation.loop().run(10);

        assertThat(pulled[0]).isCloseTo(10 / 5.0 * 0.5, within(1e-12));
        assertThat(velocity("weight")[0]).isEqualTo(pulled[0]);
        assertThat(item("weight").physics().vector("appliedForce")).containsExactly(0, 49.05, 0);
    }

    @Test
    void ironIsHeatedCarriedAndForged() throws Exception {
        assertThat(item("iron").semantic().get("advice")).contains("heat it");
        assertThat(item("iron").semantic().get("on")).contains(List.of("forge"));
        assertThat(
                        catchThrowableOfType(
                                        ActionRefused.class,
                                        () -> act("iron", "strike", Map.of("strength", 1)))
                                .code())
                .isEqualTo("condition-failed");

        for (int i = 0; i < 2; i++) {
            act("bellows", "pump", Map.of("what", "iron", "by", 450));
        }
        simulation.loop().step();
        assertThat(item("iron").semantic().get("glows")).contains(true);
        assertThat(item("iron").semantic().get("advice")).contains("strike while it is hot");

        act("iron", "take", Map.of());
        assertThat(item("iron").parent()).contains(item("smith").id());
        act("iron", "lay", Map.of("on", "anvil"));
        simulation.loop().step();
        assertThat(item("iron").semantic().get("on")).contains(List.of("anvil"));

        act("iron", "strike", Map.of("strength", 0.5));
        assertThat(world.events()).extracting(WorldEvent::type).contains("struck");
        List<Item> sparks =
                world.items().stream().filter(item -> item.name().startsWith("spark-")).toList();
        assertThat(sparks).hasSize(2);
        assertThat(item("iron").semantic().get("strokes")).contains(1.0);
        simulation.loop().run(12);
        assertThat(velocity(sparks.getFirst().name())[1])
                .isCloseTo(2.5 - 9.81 * 12 * FRAME_SECONDS, within(1e-9));
        assertThat(sparks.getFirst().semantic().get("glows")).contains(true);
        assertThat(simulation.events().faults()).isEmpty();
    }
}
