// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.AgentRoom;
import reve.core.agent.TestClient;
import reve.core.frame.FramePhase;
import reve.core.world.WorldEvent;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.Map;

/** Refusals that need a long time, or large amounts. */
class RefusalsTest {

    private static final int REMEMBERED = 1024;
    private static final int IMAGES = 32;

    @Test
    void aCommandThatMayHaveBeenDoneLongAgoIsNotDoneAgain() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient ada = room.join("ada")) {
            int atOnce = AgentRoom.CONFIG.limits().actsInFlight();
            for (int id = 0; id < REMEMBERED + atOnce; id += atOnce) {
                for (int i = 0; i < atOnce; i++) {
                    ada.say("{'t':'act','id':" + (id + i) + ",'item':'duck','action':'wind-up'}");
                }
                ada.sync();
                room.step();
                ada.sync();
            }
            ada.say("{'t':'act','id':0,'item':'duck','action':'wind-up'}");
            JsonNode result = ada.skipTo("result");
            while (result.get("accepted").booleanValue()) {
                result = ada.skipTo("result");
            }
            assertThat(result.get("code").stringValue()).isEqualTo("id-forgotten");
            assertThat(room.server.stats().actsAccepted()).isEqualTo(REMEMBERED + atOnce);
        }
    }

    @Test
    void whoMissedMoreThanIsRememberedGoesOnAndIsToldSo() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient ada = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':60}").sync();
            room.step();
            JsonNode welcome = ada.expect("welcome");
            ada.socket.close();
            room.stepUntil("its connection is gone", () -> room.server.stats().open() == 0);
            String text = "x".repeat(4000);
            var speech =
                    room.bus.subscribe(
                            FramePhase.ACT,
                            "much",
                            event -> {
                                for (int i = 0; i < EventLog.MAX_BYTES / text.length(); i++) {
                                    room.world.raise(
                                            new WorldEvent(
                                                    event.frame(), "said", Map.of("text", text)));
                                }
                            });
            room.step();
            speech.close();
            long much = room.loop.frame();
            room.step();
            try (TestClient back = room.connect()) {
                back.say(
                        "{'t':'hello','protocol':1,'name':'ada','resume':{'session':'"
                                + welcome.at("/session/token").stringValue()
                                + "','frame':1}}");
                assertThat(back.expect("welcome").get("resumed").booleanValue()).isTrue();
                assertThat(back.expect("event"))
                        .isEqualTo(
                                TestClient.json(
                                        ("{'t':'event',"
                                                        + "'frame':%1$d,'type':'missed','fields':{'first':2,'last':%1$d}}")
                                                .formatted(much)));
                back.say("{'t':'perceive','id':1}").sync();
                room.step();
                assertThat(back.expect("perception").get("id").intValue())
                        .as("none of the frame's other events")
                        .isEqualTo(1);
            }
        }
    }

    @Test
    void whenAllImagesAreTakenAnotherReplacesOneOrIsRefused() throws IOException {
        try (AgentRoom room = new AgentRoom();
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            for (int id = 0; id <= IMAGES; id++) {
                JsonNode result = snapshot(room, boss, id, "image " + id);
                assertThat(result.get("accepted").booleanValue())
                        .as("%s", result)
                        .isEqualTo(id < IMAGES);
                if (id == IMAGES) {
                    assertThat(result.get("code").stringValue()).isEqualTo("too-many-images");
                    assertThat(result.get("reason").stringValue())
                            .contains("32 images", "image 7", "replaces");
                }
            }
            assertThat(snapshot(room, boss, 100, "image 7").get("accepted").booleanValue())
                    .isTrue();
        }
    }

    private static JsonNode snapshot(AgentRoom room, TestClient boss, int id, String name)
            throws IOException {
        boss.say("{'t':'snapshot','id':" + id + ",'image':'" + name + "'}");
        room.stepUntil("it is answered", boss::hasNews);
        return boss.expect("result");
    }
}
