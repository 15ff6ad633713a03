// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.file.AgentPolicy;
import reve.core.world.Instrument;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/** The distances that a lidar measures, and what it does not disclose. */
class LidarTest {
    private static final double NOTHING = -1;
    private static final double QUARTER_TURN = Math.sqrt(0.5);

    private static Instrument.Lidar fan(int rays, double degrees, double range) {
        return new Instrument.Lidar(rays, 1, Math.toRadians(degrees), 0, range, 0, 0);
    }

    private static ItemDefinition.Builder body(Instrument lidar) {
        return ItemDefinition.named("body")
                .shape(Shape.box(1, 1, 1))
                .sensor(Sensor.measuring("scan", lidar));
    }

    private static ItemDefinition item(String name, Shape shape, double x, double y, double z) {
        return ItemDefinition.named(name).shape(shape).at(x, y, z).build();
    }

    private static AgentRoom room(ItemDefinition body, ItemDefinition... items) throws IOException {
        return new AgentRoom(
                AgentRoom.CONFIG,
                new AgentPolicy(List.of(), Optional.of(body)),
                64,
                List.of(items));
    }

    private static JsonNode perceive(AgentRoom room, TestClient client) throws IOException {
        client.say("{'t':'perceive','id':1}").sync();
        room.step();
        return client.expect("perception");
    }

    private static List<Double> distances(JsonNode perception) {
        List<Double> distances = new ArrayList<>();
        perception.at("/readings/scan/distances").forEach(one -> distances.add(one.doubleValue()));
        return distances;
    }

    private static List<Double> scanned(ItemDefinition body, ItemDefinition... items)
            throws IOException {
        try (AgentRoom room = room(body, items);
                TestClient ada = room.join("ada")) {
            JsonNode perception = perceive(room, ada);
            assertThat(perception.toString())
                    .as("only distances are disclosed")
                    .doesNotContain("secret");
            assertThat(perception.get("items")).hasSize(1);
            return distances(perception);
        }
    }

    @Test
    void aFanMeasuresTheDistancesOfClosedForms() throws IOException {
        double radius = 1;
        double far = 6;
        List<Double> found =
                scanned(
                        body(fan(41, 40, 50)).build(),
                        item("secret ball", Shape.sphere(radius), 0, 0, far),
                        item("secret wall", Shape.box(100, 100, 2), 0, 0, 11));
        assertThat(found).hasSize(41);
        for (int i = 0; i < 41; i++) {
            double angle = Math.toRadians(i - 20);
            double aside = far * Math.sin(Math.abs(angle));
            double expected =
                    aside < radius
                            ? far * Math.cos(angle) - Math.sqrt(radius * radius - aside * aside)
                            : 10 / Math.cos(angle);
            assertThat(found.get(i)).as("ray %d", i).isCloseTo(expected, within(1e-9));
        }
    }

    /** The body's own box is around its origin, and is not met. */
    @Test
    void theFirstColumnIsTowardsMinusXAndRowsAreFromBelow() throws IOException {
        var grid = new Instrument.Lidar(4, 3, Sensor.ALL_ROUND, Math.PI / 2, 20, 0, 0);
        double ground = 2;
        List<Double> found =
                scanned(
                        body(grid).build(),
                        item("secret floor", Shape.plane(60, 60), 0, -ground, 0),
                        item("secret pole", Shape.cylinder(0.5, 8), -5, 0, 0));
        double slanting = ground * Math.sqrt(2);
        assertThat(found)
                .usingElementComparator((a, b) -> Math.abs(a - b) < 1e-9 ? 0 : 1)
                .containsExactly(
                        slanting, // -Z, then -X, +Z and +X, 45 degrees downwards
                        slanting, slanting, slanting, NOTHING, 4.5, NOTHING, NOTHING, NOTHING,
                        NOTHING, NOTHING, NOTHING);
    }

    @Test
    void theRaysTurnWithTheBodyAndEndAtTheRange() throws IOException {
        ItemDefinition.Builder turned =
                body(fan(1, 0, 8)).orientation(0, QUARTER_TURN, 0, QUARTER_TURN);
        assertThat(scanned(turned.build(), item("secret", Shape.capsule(0.5, 3), 7, 0, 0)))
                .usingElementComparator((a, b) -> Math.abs(a - b) < 1e-9 ? 0 : 1)
                .containsExactly(6.5);
        assertThat(scanned(turned.build(), item("secret", Shape.capsule(0.5, 3), 9, 0, 0)))
                .containsExactly(NOTHING);
        assertThat(scanned(turned.build(), ItemDefinition.named("secret").at(5, 0, 0).build()))
                .as("an item without a shape")
                .containsExactly(NOTHING);
    }

    @Test
    void aMeshIsMetAtItsTriangles() throws IOException {
        float[] corners = {-1, -1, 0, 3, -1, 0, -1, 3, 0};
        Shape triangle = Shape.mesh(corners, new int[] {0, 1, 2});
        assertThat(
                        scanned(
                                body(fan(1, 0, 50)).build(),
                                item("secret", triangle, 0, 0, 4),
                                item("secret too", triangle, 5, 0, 2)))
                .containsExactly(4.0);
    }

    @Test
    void aSlowLidarKeepsItsReadingAndOnlyNewReadingsAreSentAgain() throws IOException {
        ItemDefinition slow =
                ItemDefinition.named("body")
                        .sensor(Sensor.measuring("scan", fan(1, 0, 50)).withEvery(3))
                        .build();
        try (AgentRoom room = room(slow, item("wall", Shape.box(9, 9, 1), 0, 0, 5));
                TestClient ada = room.join("ada")) {
            ada.say("{'t':'perceive','id':1,'every':1}").sync();
            List<String> sent = new ArrayList<>();
            for (int i = 0; i < 7; i++) {
                room.item("wall").physical().setLocation(0, 0, 5 + i);
                room.step();
                sent.add(distances(ada.expect("perception")).toString());
            }
            assertThat(sent).containsExactly("[4.5]", "[]", "[]", "[7.5]", "[]", "[]", "[10.5]");
        }
    }

    @Test
    void noiseIsAddedToTheDistancesThatWereMeasured() throws IOException {
        var noisy = new Instrument.Lidar(400, 1, Math.toRadians(90), 0, 10, 0.05, 3);
        ItemDefinition half = item("secret", Shape.box(100, 1, 2), 50.001, 0, 5);
        List<Double> exact = scanned(body(fan(400, 90, 10)).build(), half);
        List<Double> rough = scanned(body(noisy).build(), half);
        double squares = 0;
        int met = 0;
        for (int i = 0; i < 400; i++) {
            assertThat(rough.get(i) == NOTHING).isEqualTo(exact.get(i) == NOTHING);
            if (exact.get(i) != NOTHING) {
                met++;
                squares += Math.pow(rough.get(i) - exact.get(i), 2);
            }
        }
        assertThat(met).isEqualTo(200);
        assertThat(Math.sqrt(squares / met))
                .as("four standard errors")
                .isCloseTo(0.05, within(4 * 0.05 / Math.sqrt(2.0 * met)));
        assertThat(scanned(body(noisy).build(), half)).isEqualTo(rough);
    }
}
