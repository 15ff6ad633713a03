// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.agent.port.Cameras;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.util.ArrayList;
import java.util.Base64;
import java.util.EnumSet;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;

/**
 * Agents request pictures, disconnect, reconnect, leave and are rewound at random, while pictures
 * are slow or fail.
 */
class CameraFuzzTest {

    private static final int OPERATIONS = Integer.getInteger("reve.fuzz.operations", 2_000);
    private static final int AGENTS = 4;
    private static final int EVERY = 3;
    private static final Sensor EYE =
            Sensor.camera("eye", 1, new Sensor.Camera(1, 1, EnumSet.of(Sensor.Layer.COLOUR)))
                    .withEvery(EVERY);
    private static final Set<String> REFUSALS =
            Set.of("no-picture", "look-pending", "not-yet", "no-such-camera");

    private final long seed = Seed.of("the cameras");
    private final Random random = new Random(seed);
    private final List<Order> orders = new ArrayList<>();
    private final Map<String, Integer> counts = new TreeMap<>();
    private final List<Looker> lookers = new ArrayList<>();
    private AgentRoom room;
    private int names;

    /** A picture that is not drawn yet. */
    private record Order(ItemId body, Cameras.Answer answer) {}

    /** An agent with a camera, with the state that it knows of itself. */
    private final class Looker {
        private final String name = "looker" + names++;
        private final Set<Long> bodies = new HashSet<>();
        private final Set<Integer> open = new TreeSet<>();
        private final String session;
        private TestClient client;
        private int lastId;
        private int errors;
        private long lastFrame = -EVERY;

        Looker() throws IOException {
            client =
                    room.connect()
                            .say(
                                    "{'t':'hello','protocol':1,'name':'"
                                            + name
                                            + "','graceSeconds':60}");
            room.stepUntil("the looker is in the world", () -> room.has(name));
            session = client.expect("welcome").at("/session/token").stringValue();
            embody();
        }

        /**
         * Returns whether the server may have closed the connection. It does so after too many
         * refusals, and each open request may have been refused.
         */
        boolean mayBeCut() {
            return errors + open.size() >= AgentRoom.CONFIG.limits().maxErrors() - 1;
        }

        void embody() {
            bodies.add(room.item(name).id().value());
        }

        void look(String sensor) throws IOException {
            open.add(++lastId);
            say(lastId, sensor);
        }

        private void say(int id, String sensor) throws IOException {
            client.say("{'t':'look','id':" + id + ",'sensor':'" + sensor + "'}").sync();
        }

        void hear() throws IOException {
            client.sync();
            while (client.hasNews()) {
                take(client.next());
            }
        }

        void hearAll() throws IOException {
            while (!open.isEmpty()) {
                take(client.next());
            }
        }

        private void take(JsonNode message) {
            String type = message.get("t").stringValue();
            if (type.equals("event")) {
                return;
            }
            assertThat(open.remove(message.get("id").intValue()))
                    .as("nobody asked for %s", message)
                    .isTrue();
            if (type.equals("error")) {
                errors++;
                assertThat(message.get("code").stringValue()).isIn(REFUSALS);
                count(message.get("code").stringValue());
                return;
            }
            count(type);
            byte[] pixel = Base64.getDecoder().decode(message.get("colour").stringValue());
            var body = ByteBuffer.wrap(new byte[] {0, pixel[0], pixel[1], pixel[2]});
            assertThat(bodies).contains((long) body.getInt());
            long frame = message.get("frame").longValue();
            assertThat(frame == lastFrame || frame >= lastFrame + EVERY)
                    .as("frame %d after %d", frame, lastFrame)
                    .isTrue();
            lastFrame = frame;
        }

        /** Disconnects, reconnects as soon as permitted, and repeats unanswered requests. */
        void comeBack() throws IOException {
            client.socket.setSoLinger(true, 0);
            JsonNode answer;
            do {
                client.close();
                client =
                        room.connect()
                                .say(
                                        "{'t':'hello','protocol':1,'name':'"
                                                + name
                                                + "','resume':{'session':'"
                                                + session
                                                + "','frame':"
                                                + room.loop.frame()
                                                + "}}");
                answer = client.next();
            } while (answer.path("code").asString("").equals("resumed-too-often"));
            assertThat(answer.get("t").stringValue()).as("%s", answer).isEqualTo("welcome");
            errors = 0;
            lastFrame = -EVERY; // the agent cannot know what was sent meanwhile
            for (int id : open) {
                say(id, "eye");
            }
        }
    }

    @Test
    void everyLookIsAnsweredOnceByACameraOfItsOwnWhateverHappensMeanwhile() throws IOException {
        ItemDefinition body =
                ItemDefinition.named("body").shape(Shape.sphere(0.5)).sensor(EYE).build();
        try (AgentRoom agentRoom =
                        new AgentRoom(
                                AgentRoom.CONFIG,
                                new AgentPolicy(List.of(), Optional.of(body)),
                                256);
                TestClient boss = agentRoom.connect()) {
            room = agentRoom;
            room.cameras =
                    (item, camera, answer) -> {
                        synchronized (orders) {
                            orders.add(new Order(item, answer));
                        }
                    };
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            for (int i = 0; i < AGENTS; i++) {
                lookers.add(new Looker());
            }
            for (int i = 0; i < OPERATIONS; i++) {
                int which = random.nextInt(AGENTS);
                if (lookers.get(which).mayBeCut()) {
                    replace(which);
                }
                operate(boss, which);
            }
            while (draw()) {
                count("drawn at the end");
            }
            for (Looker looker : lookers) {
                looker.hearAll();
                looker.client.say("{'t':'bye'}").skipToBye("goodbye");
            }
            System.out.println(OPERATIONS + " operations: " + counts);
            assertThat(counts.get("image")).isPositive();
            room.stepUntil("all have gone", () -> room.server.stats().agents() == 0);
        }
    }

    private void operate(TestClient boss, int which) throws IOException {
        Looker looker = lookers.get(which);
        switch (random.nextInt(14)) {
            case 0, 1, 2 -> looker.look("eye");
            case 3, 4, 5 -> draw();
            case 6, 7, 8 -> room.step();
            case 9, 10 -> looker.hear();
            case 11 -> {
                count("came back");
                looker.comeBack();
            }
            case 12 -> replace(which);
            default -> {
                count("rewound");
                boss.say("{'t':'rewind','id':" + counts.get("rewound") + "}").sync();
                room.step();
                boss.skipTo("result");
                lookers.forEach(Looker::embody);
            }
        }
    }

    private void replace(int which) throws IOException {
        count("left");
        lookers.get(which).client.say("{'t':'bye'}").skipToBye("goodbye");
        lookers.get(which).client.close();
        lookers.set(which, new Looker());
    }

    /**
     * Returns one of the pictures, or its failure.
     *
     * @return false if no agent waits for one
     */
    private boolean draw() {
        Order order;
        synchronized (orders) {
            if (orders.isEmpty()) {
                return false;
            }
            order = orders.remove(random.nextInt(orders.size()));
        }
        switch (random.nextInt(6)) {
            case 0 -> order.answer().refused("there is no light");
            case 1 -> order.answer().failed(new IllegalStateException("out of paint"));
            default -> {
                byte[] id = ByteBuffer.allocate(4).putInt((int) order.body().value()).array();
                order.answer()
                        .taken(
                                new Cameras.Photo(
                                        room.loop.frame(),
                                        0,
                                        1,
                                        1,
                                        Optional.of(new byte[] {id[1], id[2], id[3]}),
                                        Optional.empty(),
                                        Optional.empty(),
                                        List.of()));
            }
        }
        return true;
    }

    private void count(String what) {
        counts.merge(what, 1, Integer::sum);
    }
}
