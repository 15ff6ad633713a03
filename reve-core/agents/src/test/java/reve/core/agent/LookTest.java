// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.audit.AuditPlan;
import reve.core.agent.port.Cameras;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayDeque;
import java.util.Deque;
import java.util.EnumSet;
import java.util.List;
import java.util.Optional;

/** Requests for camera pictures. The test replaces the renderer. */
class LookTest {

    private static final Sensor EYE =
            Sensor.camera("eye", 1, new Sensor.Camera(2, 1, EnumSet.of(Sensor.Layer.COLOUR)))
                    .withEvery(3);

    @TempDir private Path folder;
    private AgentRoom room;
    private TestClient ada;
    private final Deque<Cameras.Answer> asked = new ArrayDeque<>();

    @BeforeEach
    void join() throws IOException {
        ItemDefinition body =
                ItemDefinition.named("body").shape(Shape.sphere(0.5)).sensor(EYE).build();
        room =
                new AgentRoom(
                        AgentRoom.CONFIG.withAudit(AuditPlan.of(folder.resolve("audit.jsonl"))),
                        new AgentPolicy(List.of(), Optional.of(body)),
                        64);
        room.cameras =
                (item, camera, answer) -> {
                    assertThat(camera).isEqualTo(EYE);
                    asked.add(answer);
                };
        ada = room.join("ada");
    }

    @AfterEach
    void leave() throws IOException {
        ada.close();
        room.close();
    }

    private Cameras.Photo photo() {
        return new Cameras.Photo(
                room.loop.frame(),
                0.5,
                2,
                1,
                Optional.of(new byte[] {-1, 0, 0, 0, -1, 0}),
                Optional.empty(),
                Optional.empty(),
                List.of());
    }

    private JsonNode lookAndGet(int id) throws IOException {
        ada.say("{'t':'look','id':" + id + ",'sensor':'eye'}").sync();
        asked.remove().taken(photo());
        return ada.expect("image");
    }

    @Test
    void thePictureIsTheAnswerAndTheRecordHoldsItsHash() throws IOException {
        JsonNode image = lookAndGet(7);
        assertThat(image.get("id").intValue()).isEqualTo(7);
        assertThat(image.get("frame").longValue()).isEqualTo(room.loop.frame());
        assertThat(image.get("sensor").stringValue()).isEqualTo("eye");
        assertThat(image.get("colour").stringValue()).isEqualTo("/wAAAP8A");
        assertThat(image.has("depth") || image.has("items") || image.has("names")).isFalse();
        room.server.close();
        String record = Files.readString(folder.resolve("audit.jsonl"));
        assertThat(record).doesNotContain("/wAAAP8A").contains("\"colour\":\"sha256:");
    }

    @Test
    void onlyACameraOfItsOwnBodyCanBeAsked() throws IOException {
        ada.say("{'t':'look','id':1,'sensor':'ear'}");
        assertThat(ada.expect("error").get("code").stringValue()).isEqualTo("no-such-camera");
        try (TestClient eve = room.connect()) {
            eve.say("{'t':'hello','protocol':1,'name':'eve','role':'observer'}");
            eve.expect("welcome");
            eve.say("{'t':'look','id':1,'sensor':'eye'}");
            assertThat(eve.expect("error").get("code").stringValue()).isEqualTo("no-such-camera");
        }
        assertThat(asked).isEmpty();
    }

    private TestClient watcher(String role) throws IOException {
        TestClient client = room.connect();
        client.say("{'t':'hello','protocol':1,'name':'eve','role':'" + role + "'}");
        client.expect("welcome");
        return client;
    }

    @Test
    void theRoleControlLooksThroughTheCameraOfAnyBody() throws IOException {
        try (TestClient boss = watcher("control")) {
            boss.say("{'t':'look','id':1,'sensor':'eye','item':'ada'}").sync().sync();
            asked.remove().taken(photo());
            JsonNode image = boss.skipTo("image");
            assertThat(image.get("id").intValue()).isEqualTo(1);
            assertThat(image.get("colour").stringValue()).isEqualTo("/wAAAP8A");

            // The interval of the camera applies to each client that looks through it.
            room.step();
            boss.say("{'t':'look','id':2,'sensor':'eye','item':'ada'}");
            JsonNode early = boss.skipTo("error");
            assertThat(early.get("id").intValue()).isEqualTo(2);
            assertThat(early.get("code").stringValue()).isEqualTo("not-yet");
            assertThat(lookAndGet(7).get("frame").longValue()).isEqualTo(room.loop.frame());

            boss.say("{'t':'look','id':3,'sensor':'ear','item':'ada'}");
            JsonNode none = boss.skipTo("error");
            assertThat(none.get("code").stringValue()).isEqualTo("no-such-camera");
            assertThat(none.get("hint").stringValue()).isEqualTo("its cameras are \"eye\"");
            boss.say("{'t':'look','id':4,'sensor':'eye','item':'swan'}");
            assertThat(boss.skipTo("error").get("message").stringValue())
                    .isEqualTo("the world has no item \"swan\"");
            boss.say("{'t':'look','id':5,'sensor':'eye'}");
            assertThat(boss.skipTo("error").get("code").stringValue()).isEqualTo("no-such-camera");
        }
        assertThat(asked).isEmpty();
    }

    @Test
    void otherRolesUseTheCamerasOfTheirOwnBodyOnly() throws IOException {
        ada.say("{'t':'look','id':1,'sensor':'eye','item':'ada'}").sync().sync();
        asked.remove().taken(photo());
        assertThat(ada.expect("image").get("id").intValue()).isEqualTo(1);
        try (TestClient bob = room.join("bob");
                TestClient eve = watcher("observer")) {
            bob.say("{'t':'look','id':1,'sensor':'eye','item':'ada'}");
            JsonNode refused = bob.skipTo("error");
            assertThat(refused.get("code").stringValue()).isEqualTo("not-permitted");
            assertThat(refused.get("message").stringValue()).startsWith("agent bob may use");
            eve.say("{'t':'look','id':1,'sensor':'eye','item':'ada'}");
            assertThat(eve.skipTo("error").get("code").stringValue()).isEqualTo("not-permitted");
        }
        assertThat(asked).isEmpty();
    }

    @Test
    void theWelcomeAndTheReportListTheCamerasOfABody() throws IOException {
        try (TestClient bob = room.connect();
                TestClient boss = watcher("control")) {
            bob.say("{'t':'hello','protocol':1,'name':'bob'}").sync();
            room.step();
            assertThat(bob.expect("welcome").get("cameras").toString()).isEqualTo("[\"eye\"]");
            boss.say("{'t':'state','id':1}").sync();
            room.step();
            JsonNode clients = boss.skipTo("report").at("/content/clients");
            assertThat(clients.valueStream().map(client -> client.path("cameras").toString()))
                    .containsExactly("[\"eye\"]", "[\"eye\"]", "");
        }
    }

    @Test
    void oneLookAtATime() throws IOException {
        ada.say("{'t':'look','id':1,'sensor':'eye'}").say("{'t':'look','id':2,'sensor':'eye'}");
        JsonNode error = ada.expect("error");
        assertThat(error.get("id").intValue()).isEqualTo(2);
        assertThat(error.get("code").stringValue()).isEqualTo("look-pending");
        asked.remove().taken(photo());
        assertThat(ada.expect("image").get("id").intValue()).isEqualTo(1);
    }

    @Test
    void aCameraTakesAPictureEverySomeFrames() throws IOException {
        long first = lookAndGet(1).get("frame").longValue();
        room.step();
        ada.say("{'t':'look','id':2,'sensor':'eye'}");
        JsonNode error = ada.expect("error");
        assertThat(error.get("code").stringValue()).isEqualTo("not-yet");
        assertThat(error.get("hint").stringValue()).contains("frame " + (first + 3));
        room.step();
        room.step();
        assertThat(lookAndGet(3).get("frame").longValue()).isEqualTo(first + 3);
    }

    @Test
    void aPictureThatFailsIsAnErrorThatTellsNothingOfTheServerAndTheNextMaySucceed()
            throws IOException {
        ada.say("{'t':'look','id':1,'sensor':'eye'}").sync();
        asked.remove()
                .failed(new IllegalStateException("there is no program /opt/server/vesper-render"));
        JsonNode error = ada.expect("error");
        assertThat(error.get("code").stringValue()).isEqualTo("no-picture");
        assertThat(error.get("message").stringValue())
                .isEqualTo("the picture could not be drawn; the server's log says why");
        assertThat(error.toString()).doesNotContain("/opt");
        assertThat(lookAndGet(2).get("id").intValue()).isEqualTo(2);
    }

    @Test
    void whoLeavesBeforeThePictureIsThereCostsNothing() throws IOException {
        ada.say("{'t':'look','id':1,'sensor':'eye'}").sync();
        ada.say("{'t':'bye'}");
        ada.expect("bye");
        asked.remove().taken(photo());
        try (TestClient bob = room.join("bob")) {
            assertThat(bob.say("{'t':'ping','id':4}").expect("pong").get("id").intValue())
                    .isEqualTo(4);
        }
    }

    @Test
    void aCameraSensesNoItems() throws IOException {
        ada.say("{'t':'perceive','id':1}").sync();
        room.step();
        assertThat(
                        ada.expect("perception")
                                .get("items")
                                .valueStream()
                                .map(item -> item.get("name").stringValue()))
                .containsExactly("ada");
        ada.say("{'t':'act','id':2,'item':'duck','action':'push','arguments':{'impulse':[1,0,0]}}")
                .sync();
        room.step();
        assertThat(ada.expect("result").get("code").stringValue()).isEqualTo("no-such-item");
    }
}
