// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import com.sun.management.ThreadMXBean;

import org.junit.jupiter.api.Test;

import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/**
 * The amount of garbage of the event loop. If there were much garbage, its collection would stop
 * the world.
 */
class PerceptionMemoryTest {

    private static final int AGENTS = 20;
    private static final int ITEMS = 50;
    private static final int MOVING = 5;

    /**
     * Most bytes of garbage of a perception. 200 of them belong to a view of 50 items, which lives
     * until the next view.
     */
    private static final long MOST_BYTES = 1536;

    @Test
    void aPerceptionLeavesLittle() throws IOException {
        var bodies = new ArrayList<String>();
        var items = new ArrayList<ItemDefinition>();
        for (int i = 0; i < AGENTS; i++) {
            bodies.add("agent-" + i);
            items.add(
                    ItemDefinition.named("agent-" + i)
                            .at(0, i, 0)
                            .sensor(Sensor.sight("eyes", 100))
                            .build());
        }
        for (int i = AGENTS; i < ITEMS; i++) {
            items.add(
                    ItemDefinition.named("item-" + i).shape(Shape.sphere(0.5)).at(i, 0, 0).build());
        }
        try (var room =
                new AgentRoom(
                        AgentRoom.CONFIG, new AgentPolicy(bodies, Optional.empty()), 64, items)) {
            var clients = new ArrayList<TestClient>();
            for (String body : bodies) {
                clients.add(
                        room.connect()
                                .say(
                                        "{'t':'hello','protocol':1,'name':'"
                                                + body
                                                + "','body':'"
                                                + body
                                                + "'}")
                                .say("{'t':'perceive','every':1}")
                                .sync());
            }
            frames(room, clients, 400);
            long before = allocatedByEventLoop();
            frames(room, clients, 100);
            long bytes = (allocatedByEventLoop() - before) / (100 * AGENTS);
            System.out.println("bytes of a perception: " + bytes);
            assertThat(bytes).isBetween(1L, MOST_BYTES);
            for (TestClient client : clients) {
                client.close();
            }
        }
    }

    /** Makes frames, each when all clients have the perception of the frame before. */
    private static void frames(AgentRoom room, List<TestClient> clients, int count)
            throws IOException {
        for (int frame = 0; frame < count; frame++) {
            for (int i = 0; i < MOVING; i++) {
                room.item("item-" + (ITEMS - 1 - i)).physical().setLocation(i, frame, 1);
            }
            room.step();
            for (TestClient client : clients) {
                client.skipTo("perception");
            }
        }
    }

    private static long allocatedByEventLoop() {
        var threads = (ThreadMXBean) ManagementFactory.getThreadMXBean();
        return Thread.getAllStackTraces().keySet().stream()
                .filter(thread -> thread.getName().equals("agents"))
                .mapToLong(thread -> threads.getThreadAllocatedBytes(thread.threadId()))
                .sum();
    }
}
