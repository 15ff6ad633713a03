// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.file.AgentPolicy;
import reve.core.frame.FramePhase;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.WorldEvent;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;

/**
 * A client receives an event if it perceives, or last received, one of the event's items; other
 * clients do not.
 */
class EventRoutingTest {

    private static final int AGENTS = 12;
    private static final int BELLS = 24;
    private static final int FRAMES = 40;

    private final long seed = Seed.of("events");
    private final Random random = new Random(seed);
    private final List<TestClient> clients = new ArrayList<>();
    private final List<Set<String>> shown = new ArrayList<>();
    private AgentRoom room;

    @BeforeEach
    void join() throws IOException {
        var items = new ArrayList<ItemDefinition>();
        var names = new ArrayList<String>();
        for (int i = 0; i < AGENTS; i++) {
            names.add("agent-" + i);
            items.add(body("agent-" + i, i));
        }
        for (int i = 0; i < BELLS; i++) {
            items.add(
                    place(ItemDefinition.named("bell-" + i))
                            .shape(Shape.sphere(random.nextDouble(0.1, 1)))
                            .build());
        }
        room = new AgentRoom(AgentRoom.CONFIG, new AgentPolicy(names, Optional.empty()), 64, items);
        for (String name : names) {
            clients.add(
                    room.connect()
                            .say(
                                    "{'t':'hello','protocol':1,'name':'"
                                            + name
                                            + "','body':'"
                                            + name
                                            + "'}")
                            .say("{'t':'perceive','every':1}")
                            .sync());
            shown.add(new HashSet<>());
        }
        room.bus.subscribe(FramePhase.ACT, "bells", event -> ring(event.frame()));
    }

    @AfterEach
    void leave() throws IOException {
        for (TestClient client : clients) {
            client.close();
        }
        room.close();
    }

    /**
     * The first agent has no sensors, and the second agent has only a camera. The other agents
     * sense some items.
     */
    private ItemDefinition body(String name, int i) {
        ItemDefinition.Builder body =
                place(ItemDefinition.named(name))
                        .shape(Shape.box(0.5, 1, 0.5))
                        .orientation(
                                random.nextGaussian(),
                                random.nextGaussian(),
                                random.nextGaussian(),
                                1);
        return switch (i) {
            case 0 -> body.build();
            case 1 ->
                    body.sensor(
                                    Sensor.camera(
                                            "eye",
                                            1,
                                            new Sensor.Camera(1, 1, Set.of(Sensor.Layer.DEPTH))))
                            .build();
            case 2 -> body.sensor(Sensor.sight("all", Double.POSITIVE_INFINITY)).build();
            case 3 ->
                    body.sensor(Sensor.sight("far", Double.POSITIVE_INFINITY).withLineOfSight())
                            .build();
            case 4 -> body.sensor(Sensor.touch("skin")).sensor(sight("eyes")).build();
            default -> body.sensor(sight("eyes")).build();
        };
    }

    private Sensor sight(String name) {
        Sensor sight = Sensor.sight(name, random.nextDouble(1, 6));
        sight = random.nextBoolean() ? sight.withFieldOfView(random.nextDouble(1, 6)) : sight;
        return random.nextBoolean() ? sight.withLineOfSight() : sight;
    }

    private ItemDefinition.Builder place(ItemDefinition.Builder item) {
        return item.at(
                random.nextDouble(-6, 6), random.nextDouble(-6, 6), random.nextDouble(-6, 6));
    }

    /** Some items move, one leaves, and each item raises an event. */
    private void ring(long frame) {
        for (Item item : room.world.items()) {
            if (item.kind().equals("world")) {
                continue;
            }
            if (random.nextInt(3) == 0) {
                item.physical()
                        .setLocation(
                                random.nextDouble(-6, 6),
                                random.nextDouble(-6, 6),
                                random.nextDouble(-6, 6));
            }
            room.world.raise(new WorldEvent(frame, "rang", Map.of("item", item.name())));
            if (random.nextInt(200) == 0 && item.name().startsWith("bell")) {
                room.world.remove(item.id());
            }
        }
    }

    @Test
    void everybodyHearsOfWhatItPerceivesOrWasShownAndOfNothingElse() throws IOException {
        var heard = new TreeMap<String, Integer>();
        for (int frame = 1; frame <= FRAMES; frame++) {
            room.step();
            for (int agent = 0; agent < AGENTS; agent++) {
                var rang = new TreeSet<String>();
                JsonNode message = clients.get(agent).next();
                for (;
                        !message.get("t").stringValue().equals("perception");
                        message = clients.get(agent).next()) {
                    if (message.path("type").asString("").equals("rang")) {
                        rang.add(message.at("/fields/item").stringValue());
                    }
                }
                var expected = new TreeSet<>(shown.get(agent));
                update(shown.get(agent), message);
                expected.addAll(shown.get(agent));
                if (agent == 0) {
                    assertThat(rang).as("seed %d frame %d", seed, frame).containsAll(expected);
                } else {
                    assertThat(rang)
                            .as("seed %d frame %d agent %d", seed, frame, agent)
                            .isEqualTo(expected);
                }
                heard.merge("agent-" + agent, rang.size(), Integer::sum);
            }
        }
        var most = new HashMap<>(heard);
        assertThat(heard.get("agent-1")).as("one that senses only itself").isEqualTo(FRAMES);
        assertThat(most.remove("agent-0")).isGreaterThan(FRAMES * BELLS / 2);
        assertThat(most.remove("agent-2")).isGreaterThan(FRAMES * BELLS / 2);
        assertThat(most.values())
                .anySatisfy(count -> assertThat(count).isBetween(2 * FRAMES, FRAMES * BELLS));
    }

    private static void update(Set<String> known, JsonNode perception) {
        if (perception.has("items")) {
            known.clear();
        }
        perception.path("left").forEach(name -> known.remove(name.stringValue()));
        perception.path("items").forEach(item -> known.add(item.get("name").stringValue()));
        perception.path("entered").forEach(item -> known.add(item.get("name").stringValue()));
    }
}
