// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.file.AgentPolicy;
import reve.core.frame.FramePhase;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.WorldEvent;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.ArrayList;
import java.util.EnumSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Events whose receivers must be found along lines of sight, in a world in which each line passes
 * all items. The event loop searches only for some of them.
 */
class EventSightTest {
    private static final int AGENTS = 40;
    private static final int BOXES = 2_000;
    private static final int EVENTS = 10;

    /** Searches of a frame: 100,000 boxes may be examined, and the last search is completed. */
    private static final int MOST_SEARCHES = 100_000 / BOXES + 1;

    private static ItemDefinition body(int i) {
        double angle = 2 * Math.PI * i / AGENTS;
        return ItemDefinition.named("agent-" + i)
                .shape(Shape.sphere(0.1))
                .at(5 * Math.cos(angle), 0, 5 * Math.sin(angle))
                .sensor(
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
                                Optional.empty()))
                .build();
    }

    @Test
    void searchesAreLimitedAndTheOtherAgentsLearnWhatTheyMissed() throws IOException {
        var items = new ArrayList<ItemDefinition>();
        var names = new ArrayList<String>();
        for (int i = 0; i < AGENTS; i++) {
            names.add("agent-" + i);
            items.add(body(i));
        }
        items.add(ItemDefinition.named("bell").shape(Shape.sphere(0.1)).build());
        for (int i = 0; i < BOXES; i++) {
            items.add(ItemDefinition.named("box-" + i).shape(Shape.box(50 + i, 50, 50)).build());
        }
        try (var room =
                new AgentRoom(
                        AgentRoom.CONFIG, new AgentPolicy(names, Optional.empty()), 64, items)) {
            List<TestClient> clients = new ArrayList<>();
            for (String name : names) {
                clients.add(
                        room.connect()
                                .say(
                                        "{'t':'hello','protocol':1,'name':'"
                                                + name
                                                + "','body':'"
                                                + name
                                                + "'}")
                                .sync());
            }
            for (int i = 0; i < 3; i++) { // until all know that the others have joined
                room.step();
                for (TestClient client : clients) {
                    client.sync();
                    while (client.hasNews()) {
                        client.next();
                    }
                }
            }
            room.bus.subscribe(
                    FramePhase.ACT,
                    "bell",
                    event -> {
                        for (int i = 0; i < EVENTS; i++) {
                            room.world.raise(
                                    new WorldEvent(event.frame(), "rang", Map.of("item", "bell")));
                        }
                    });
            room.step();
            int searched = 0;
            for (TestClient client : clients) {
                client.sync();
                int rang = 0;
                int missed = 0;
                while (client.hasNews()) {
                    JsonNode event = client.next();
                    switch (event.path("type").asString("")) {
                        case "rang" -> rang++;
                        case "missed" -> missed += event.at("/fields/events").intValue();
                        default -> {}
                    }
                }
                assertThat(rang + missed).as("received and missed events").isEqualTo(EVENTS);
                searched += rang;
            }
            assertThat(searched).isBetween(MOST_SEARCHES / 3, MOST_SEARCHES);
        }
    }
}
