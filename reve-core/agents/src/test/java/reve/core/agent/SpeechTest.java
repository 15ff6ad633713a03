// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.auth.Rights;
import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.embodiment.Outcome;
import reve.core.agent.protocol.ActionRequest;
import reve.core.agent.protocol.Role;
import reve.core.file.AgentPolicy;
import reve.core.image.WorldDigest;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.Voice;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** Agents speak, and other agents hear them as their sensors allow, over the wire. */
class SpeechTest {

    private static final Voice CLEAR = new Voice(10, Double.POSITIVE_INFINITY);
    private static final int SECOND = 60;
    private static final JsonMapper JSON = new JsonMapper();

    private static ItemDefinition.Builder body(String name, double x) {
        return ItemDefinition.named(name).shape(Shape.box(0.5, 1, 0.5)).at(x, 0, 0);
    }

    private static AgentRoom room(ItemDefinition... bodies) throws IOException {
        return room(policy(bodies), bodies);
    }

    private static AgentPolicy policy(ItemDefinition... bodies) {
        return new AgentPolicy(
                List.of(bodies).stream().map(ItemDefinition::name).toList(), Optional.empty());
    }

    private static AgentRoom room(AgentPolicy policy, ItemDefinition... bodies) throws IOException {
        return new AgentRoom(AgentRoom.CONFIG, policy, 4096, List.of(bodies));
    }

    /** Joins with the body of the agent's name, and reads the welcome. */
    private static TestClient join(AgentRoom room, String name) throws IOException {
        TestClient client =
                room.connect().say("{'t':'hello','protocol':1,'name':'" + name + "'}").sync();
        room.step();
        client.expect("welcome");
        return client;
    }

    private static String say(int id, String body, String text) {
        return JSON.writeValueAsString(
                Map.of(
                        "t",
                        "act",
                        "id",
                        id,
                        "item",
                        body,
                        "action",
                        "say",
                        "arguments",
                        Map.of("text", text)));
    }

    private static void send(TestClient client, String line) throws IOException {
        client.send((line + "\n").getBytes(StandardCharsets.UTF_8));
    }

    /** Speaks, makes one frame, and returns the result. */
    private static JsonNode said(AgentRoom room, TestClient client, String body, String text)
            throws IOException {
        send(client, say(1 + (int) room.loop.frame(), body, text));
        client.sync();
        room.step();
        return client.skipTo("result");
    }

    /** Returns the events of that type among what has arrived. */
    private static List<JsonNode> events(TestClient client, String type) throws IOException {
        client.sync();
        var events = new ArrayList<JsonNode>();
        while (client.hasNews()) {
            JsonNode message = client.next();
            if (message.path("type").asString("").equals(type)) {
                events.add(message);
            }
        }
        return events;
    }

    @Test
    void agentsInRangeHearWhomTheySeeByNameAndOthersAsAVoice() throws IOException {
        try (AgentRoom room =
                        room(
                                body("ada", 0)
                                        .voice(CLEAR)
                                        .sensor(Sensor.hearing("ears", 99))
                                        .build(),
                                body("bob", 4)
                                        .sensor(Sensor.hearing("ears", 99))
                                        .sensor(Sensor.sight("eyes", 50))
                                        .build(),
                                body("cat", -8).sensor(Sensor.hearing("ears", 99)).build(),
                                body("dan", 10.5).sensor(Sensor.hearing("ears", 99)).build(),
                                body("eve", 6).sensor(Sensor.hearing("ears", 5.9)).build(),
                                body("fay", 1).sensor(Sensor.sight("eyes", 50)).build());
                TestClient ada = join(room, "ada");
                TestClient bob = join(room, "bob");
                TestClient cat = join(room, "cat");
                TestClient dan = join(room, "dan");
                TestClient eve = join(room, "eve");
                TestClient fay = join(room, "fay")) {
            bob.say("{'t':'perceive','id':1,'every':1}").sync();
            room.step();
            bob.skipTo("perception");
            JsonNode result = said(room, ada, "ada", "come to the bridge");
            assertThat(result.get("accepted").booleanValue()).as("%s", result).isTrue();
            long frame = result.get("frame").longValue();

            assertThat(bob.expect("event"))
                    .as("before the perception of its frame")
                    .isEqualTo(
                            TestClient.json(
                                    ("{'t':'event','frame':%d,'type':'heard','fields':{'text':'come"
                                                    + " to the bridge','speaker':'ada','direction':[-1.0,0.0,0.0],'distance':4.0}}")
                                            .formatted(frame)));
            assertThat(bob.expect("perception").get("frame").longValue()).isEqualTo(frame);
            assertThat(events(cat, "heard"))
                    .extracting(event -> event.get("fields"))
                    .containsExactly(
                            TestClient.json(
                                    "{'text':'come to the bridge','direction':[1.0,0.0,0.0],"
                                            + "'distance':8.0}"));
            assertThat(events(dan, "heard")).as("beyond the voice").isEmpty();
            assertThat(events(eve, "heard")).as("beyond the ears").isEmpty();
            assertThat(events(fay, "heard")).as("no ears").isEmpty();
            assertThat(events(ada, "heard")).as("the speaker itself").isEmpty();
        }
    }

    @Test
    void onlyObserversReceiveTheRecordOfAnUtterance() throws IOException {
        try (AgentRoom room =
                        room(
                                body("ada", 0).voice(new Voice(1, 0.1)).build(),
                                body("bob", 500).build(),
                                body("cat", 1).sensor(Sensor.sight("eyes", 50)).build());
                TestClient eye = room.connect();
                TestClient ada = join(room, "ada");
                TestClient bob = join(room, "bob");
                TestClient cat = join(room, "cat")) {
            eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}").sync();
            assertThat(said(room, ada, "ada", "hush").get("accepted").booleanValue()).isTrue();
            assertThat(events(eye, "spoke"))
                    .extracting(event -> event.get("fields"))
                    .containsExactly(TestClient.json("{'agent':'ada','body':'ada','text':'hush'}"));
            assertThat(events(eye, "heard")).isEmpty();
            assertThat(events(bob, "heard"))
                    .as("an agent without sensors perceives everything")
                    .extracting(event -> event.get("fields").get("speaker").stringValue())
                    .containsExactly("ada");
            for (TestClient agent : List.of(ada, cat)) {
                agent.sync();
                while (agent.hasNews()) {
                    assertThat(agent.next().toString()).doesNotContain("hush");
                }
            }
        }
    }

    @Test
    void noSensorThatOnlyHearsPerceivesItems() throws IOException {
        try (AgentRoom room =
                        room(
                                body("ada", 0)
                                        .sensor(Sensor.hearing("ears", Double.POSITIVE_INFINITY))
                                        .build(),
                                body("bob", 1).build());
                TestClient ada = join(room, "ada")) {
            ada.say("{'t':'perceive','id':1}").sync();
            room.step();
            assertThat(ada.skipTo("perception").get("items"))
                    .extracting(item -> item.get("name").stringValue())
                    .containsExactly("ada");
        }
    }

    @Test
    void nobodySpeaksWithAnothersVoiceOrWithoutOne() throws IOException {
        try (AgentRoom room = room(body("ada", 0).voice(CLEAR).build(), body("bob", 1).build());
                TestClient bob = join(room, "bob");
                TestClient ada = join(room, "ada")) {
            JsonNode asAda = said(room, bob, "ada", "I am ada");
            assertThat(asAda.get("code").stringValue()).isEqualTo("no-such-action");
            JsonNode mute = said(room, bob, "bob", "I am bob");
            assertThat(mute.get("code").stringValue()).isEqualTo("no-such-action");
            assertThat(mute.get("reason").stringValue())
                    .endsWith("Your body has no `voice` in the world file");
            assertThat(events(ada, "heard")).isEmpty();
        }
    }

    @Test
    void aTextHasAtLeastAWordAndAtMost256Characters() throws IOException {
        try (AgentRoom room =
                        room(
                                body("ada", 0).voice(CLEAR).build(),
                                body("bob", 1).sensor(Sensor.hearing("ears", 9)).build());
                TestClient ada = join(room, "ada");
                TestClient bob = join(room, "bob")) {
            assertThat(said(room, ada, "ada", "x".repeat(257)).get("reason").stringValue())
                    .isEqualTo(
                            "`text` of action say takes a text of at least one word and at most 256"
                                    + " characters, found 257 characters");
            assertThat(said(room, ada, "ada", " \n").get("reason").stringValue())
                    .endsWith("found no word");
            send(
                    ada,
                    "{\"t\":\"act\",\"id\":900,\"item\":\"ada\",\"action\":\"say\",\"arguments\":{\"text\":3}}");
            ada.sync();
            room.step();
            assertThat(ada.skipTo("result").get("code").stringValue()).isEqualTo("wrong-type");
            String longest = "é".repeat(256);
            assertThat(said(room, ada, "ada", longest).get("accepted").booleanValue()).isTrue();
            assertThat(events(bob, "heard"))
                    .extracting(event -> event.get("fields").get("text").stringValue())
                    .containsExactly(longest);
        }
    }

    /** A text of a client is data: it arrives as it was said, in one line of the connection. */
    @Test
    void aHostileTextArrivesAsItWasSaid() throws IOException {
        String hostile =
                "\u001b[2J\r\n{\"t\":\"bye\"}\u0000\u2028\u202e\u200b ${x} \\ \"quoted\" \ud83e\udd86";
        try (AgentRoom room =
                        room(
                                body("ada", 0).voice(CLEAR).build(),
                                body("bob", 1).sensor(Sensor.hearing("ears", 9)).build());
                TestClient ada = join(room, "ada");
                TestClient bob = join(room, "bob")) {
            assertThat(said(room, ada, "ada", hostile).get("accepted").booleanValue()).isTrue();
            assertThat(events(bob, "heard"))
                    .extracting(event -> event.get("fields").get("text").stringValue())
                    .containsExactly(hostile);
        }
    }

    /** The record has "spoke", "agent" "ada", "body" "ada", "text" and the text. */
    @Test
    void anUtteranceCountsAsAnEventOfTheAgentsBudget() throws IOException {
        int others = 5 + 5 + 3 + 4 + 3 + 4;
        ItemDefinition speaker = body("ada", 0).voice(CLEAR).build();
        ItemDefinition hearer = body("bob", 1).sensor(Sensor.hearing("ears", 9)).build();
        try (AgentRoom room = room(policy(speaker, hearer).withEvents(200, 1000), speaker, hearer);
                TestClient ada = join(room, "ada");
                TestClient bob = join(room, "bob")) {
            do {
                room.step();
            } while (room.loop.frame() % SECOND != 0);
            String text = "x".repeat(100 - others);
            assertThat(said(room, ada, "ada", text).get("accepted").booleanValue()).isTrue();
            assertThat(said(room, ada, "ada", text + "x").get("code").stringValue())
                    .isEqualTo("too-many-events");
            assertThat(said(room, ada, "ada", text).get("accepted").booleanValue()).isTrue();
            assertThat(said(room, ada, "ada", "x").get("code").stringValue())
                    .isEqualTo("too-many-events");
            assertThat(events(bob, "heard")).hasSize(2);
        }
    }

    /** A crowd that listens makes an utterance dear for its speaker, not for other agents. */
    @Test
    void whoTalksWithoutPauseWaitsAndDelaysNobody() throws IOException {
        int crowd = 60;
        var bodies = new ArrayList<ItemDefinition>();
        bodies.add(body("ada", 0).voice(CLEAR).build());
        bodies.add(body("zoe", 1).voice(CLEAR).build());
        for (int i = 0; i < crowd; i++) {
            bodies.add(body("ear" + i, 2).sensor(Sensor.hearing("ears", 9)).build());
        }
        ItemDefinition[] all = bodies.toArray(ItemDefinition[]::new);
        try (AgentRoom room = room(policy(all).withEvents(1_000_000, 1_000_000), all);
                TestClient ada = join(room, "ada");
                TestClient zoe = join(room, "zoe")) {
            var clients = new ArrayList<TestClient>();
            try {
                for (int i = 0; i < crowd; i++) {
                    clients.add(
                            room.connect()
                                    .say("{'t':'hello','protocol':1,'name':'ear" + i + "'}")
                                    .sync());
                }
                room.step();
                int flood = 60;
                for (int i = 0; i < flood; i++) {
                    send(ada, say(i, "ada", "blah"));
                }
                ada.sync();
                room.step();
                send(zoe, say(1, "zoe", "excuse me"));
                zoe.sync();
                room.step();
                assertThat(zoe.skipTo("result").get("frame").longValue())
                        .isEqualTo(room.loop.frame());
                var frames = new HashMap<Long, Integer>();
                room.stepUntil("ada has said everything", () -> hasResults(ada, flood, frames));
                // An utterance costs 100 steps, 62 for the agents and 60 x 40 for the hearers.
                assertThat(frames.values()).allMatch(count -> count <= 9);
                int last = clients.size() - 1;
                assertThat(events(clients.get(last), "heard")).hasSize(flood + 1);
            } finally {
                for (TestClient client : clients) {
                    client.close();
                }
            }
        }
    }

    private static boolean hasResults(TestClient client, int wanted, Map<Long, Integer> frames) {
        try {
            client.sync();
            while (client.hasNews()) {
                JsonNode message = client.next();
                if (message.get("t").stringValue().equals("result")) {
                    assertThat(message.get("accepted").booleanValue()).as("%s", message).isTrue();
                    frames.merge(message.get("frame").longValue(), 1, Integer::sum);
                }
            }
        } catch (IOException e) {
            throw new AssertionError(e);
        }
        return frames.values().stream().mapToInt(Integer::intValue).sum() == wanted;
    }

    @Test
    void aTokenThatLimitsCapabilitiesPermitsSpeechOnlyIfItListsIt() {
        for (boolean permitted : new boolean[] {false, true}) {
            World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
            ItemDefinition speaker = body("body", 0).voice(CLEAR).build();
            var members = new Embodiment(new AgentPolicy(List.of(), Optional.of(speaker)), SECOND);
            var rights =
                    new Rights(
                            Set.of(Role.AGENT),
                            Optional.empty(),
                            Optional.empty(),
                            Optional.of(permitted ? Set.of("grip", "speak") : Set.of("grip")),
                            true);
            members.apply(world, 1, new AgentInput.Join("ada", Optional.empty(), rights));
            members.apply(world, 1, new AgentInput.Join("bob", Optional.empty(), Rights.ALL));
            Outcome outcome =
                    members.apply(
                            world,
                            1,
                            new AgentInput.Act(
                                    "ada",
                                    new ActionRequest(
                                            Optional.empty(), "say", Map.of("text", "hi"))));
            if (permitted) {
                assertThat(outcome).isEqualTo(new Outcome.Done(1));
                assertThat(members.takeHeard()).hasSize(1);
                assertThat(members.takeHeard()).isEmpty();
            } else {
                assertThat(outcome)
                        .isInstanceOfSatisfying(
                                Outcome.Refused.class,
                                refused -> assertThat(refused.code()).isEqualTo("not-capable"));
                assertThat(members.takeHeard()).isEmpty();
            }
        }
    }

    /** Speech is no state: the columns of the world are the same with and without it. */
    @Test
    void aWorldIsTheSameToTheBitWithAndWithoutSpeech() throws IOException {
        var digests = new ArrayList<long[]>();
        for (boolean talking : new boolean[] {false, true}) {
            try (AgentRoom room =
                            room(
                                    body("ada", 0).voice(CLEAR).physics("mass", 1).build(),
                                    body("bob", 1).sensor(Sensor.hearing("ears", 9)).build());
                    TestClient ada = join(room, "ada");
                    TestClient bob = join(room, "bob")) {
                for (int i = 0; i < 5; i++) {
                    if (talking) {
                        said(room, ada, "ada", "la la " + i);
                    } else {
                        room.step();
                    }
                }
                assertThat(events(bob, "heard")).hasSize(talking ? 5 : 0);
                var digest = new WorldDigest(room.world);
                var numbers = new long[digest.size()];
                digest.compute(numbers);
                digests.add(numbers);
            }
        }
        assertThat(digests.getLast()).isEqualTo(digests.getFirst());
    }

    /**
     * Losses depend on the world, the frame and the bodies, so a repetition gives the same bits.
     */
    @Test
    void aRepetitionLosesTheSameWords() throws IOException {
        var runs = new ArrayList<List<JsonNode>>();
        for (int run = 0; run < 2; run++) {
            try (AgentRoom room =
                            room(
                                    body("ada", 0).voice(new Voice(100, 8)).build(),
                                    body("bob", 7).sensor(Sensor.hearing("ears", 99)).build());
                    TestClient ada = join(room, "ada");
                    TestClient bob = join(room, "bob")) {
                for (int i = 0; i < 30; i++) {
                    said(room, ada, "ada", "one two three four five six");
                }
                runs.add(events(bob, "heard"));
            }
        }
        assertThat(runs.getFirst()).hasSizeGreaterThan(20);
        assertThat(runs.getFirst())
                .anyMatch(event -> event.get("fields").has("lost"))
                .isEqualTo(runs.getLast());
    }
}
