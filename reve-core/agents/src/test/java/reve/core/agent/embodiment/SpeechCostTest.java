// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.auth.Rights;
import reve.core.derive.BoundingBoxes;
import reve.core.world.EventBudget;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.Voice;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.EnumSet;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.TreeMap;

/** A text costs its speaker what the search for its hearers costs the world. */
class SpeechCostTest {
    private static final int HEARERS = 50;

    private static Body body(Item item) {
        return new Body(
                item.id(), item.name(), false, OptionalInt.empty(), item.sensors(), Rights.ALL);
    }

    private static long speak(Speech speech, World world, TreeMap<String, Body> bodies)
            throws Exception {
        Item speaker = world.find("ada").orElseThrow();
        return speech.say(world, 1, "ada", speaker, Map.of("text", "hi"), bodies);
    }

    private static long known(Speech speech) {
        return speech.takeHeard().stream()
                .filter(heard -> heard.event().fields().get("speaker") != null)
                .count();
    }

    /**
     * The hearers stand around the speaker. All boxes contain the agents, so that each line of
     * sight passes all of them, and none hides the speaker.
     */
    @Test
    void linesOfSightAreLimitedAndPaidFor() throws Exception {
        int boxes = 2_000;
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            world.add(
                    ItemDefinition.named("ada")
                            .shape(Shape.sphere(0.1))
                            .voice(new Voice(100, Double.POSITIVE_INFINITY))
                            .sensor(Sensor.hearing("ears", 100))
                            .build());
            Sensor eyes =
                    new Sensor(
                            "eyes",
                            false,
                            100,
                            Sensor.ALL_ROUND,
                            true,
                            1,
                            Optional.empty(),
                            EnumSet.allOf(Sensor.Aspect.class),
                            Optional.empty(),
                            Optional.empty());
            for (int i = 0; i < HEARERS; i++) {
                world.add(
                        ItemDefinition.named("hearer " + i)
                                .shape(Shape.sphere(0.1))
                                .at(
                                        3 * Math.cos(2 * Math.PI * i / HEARERS),
                                        0,
                                        3 * Math.sin(2 * Math.PI * i / HEARERS))
                                .sensor(Sensor.hearing("ears", 100))
                                .sensor(eyes)
                                .build());
            }
            for (int i = 0; i < boxes; i++) {
                world.add(
                        ItemDefinition.named("box " + i).shape(Shape.box(50 + i, 50, 50)).build());
            }
            new BoundingBoxes().update(world);
            var bodies = new TreeMap<String, Body>();
            bodies.put("ada", body(world.find("ada").orElseThrow()));
            for (int i = 0; i < HEARERS; i++) {
                bodies.put("agent " + i, body(world.find("hearer " + i).orElseThrow()));
            }
            var speech = new Speech(EventBudget.unlimited());

            long rows = world.table(WorldPrototype.BODY).rowCount();
            long first = speak(speech, world, bodies);
            assertThat(first - (long) HEARERS * Speech.OF_HEARER)
                    .isGreaterThan(Speech.MOST_PASSED)
                    .isLessThan(28_000);
            long known = known(speech);
            assertThat(known).as("hearers that see the speaker").isBetween(5L, 11L);

            long second = speak(speech, world, bodies);
            assertThat(first - second).as("steps to load all bodies").isEqualTo(rows);
            assertThat(known(speech)).isEqualTo(known);

            world.find("box 0").orElseThrow().physical().setLocation(0, 1, 0);
            assertThat(speak(speech, world, bodies)).isEqualTo(first);
        }
    }
}
