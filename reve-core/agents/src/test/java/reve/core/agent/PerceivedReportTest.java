// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.List;
import java.util.Optional;

/** The report of what an agent perceived last. The duck is 2.7 m away from new bodies. */
class PerceivedReportTest {
    private AgentRoom room;

    @AfterEach
    void close() {
        room.close();
    }

    private static TestClient watcher(AgentRoom room, String role) throws IOException {
        TestClient client = room.connect();
        client.say("{'t':'hello','protocol':1,'name':'" + role + "','role':'" + role + "'}");
        client.expect("welcome");
        return client;
    }

    private static JsonNode ask(TestClient asker, String agent) throws IOException {
        asker.say("{'t':'perceived','id':1,'client':'" + agent + "'}");
        JsonNode report = asker.skipTo("report");
        assertThat(report.get("of").stringValue()).isEqualTo("perceived");
        return report.get("content");
    }

    private static AgentRoom seeing(double metres) throws IOException {
        ItemDefinition body =
                ItemDefinition.named("body")
                        .shape(Shape.box(0.5, 1, 0.5))
                        .at(0, 0.5, 0)
                        .sensor(Sensor.sight("eyes", metres))
                        .build();
        return new AgentRoom(AgentRoom.CONFIG, new AgentPolicy(List.of(), Optional.of(body)), 64);
    }

    @Test
    void theReportListsTheItemsOfTheLastPerception() throws IOException {
        room = seeing(3);
        try (TestClient ada = room.join("ada");
                TestClient eye = watcher(room, "observer")) {
            assertThat(ask(eye, "ada").toString())
                    .isEqualTo("{\"everything\":false,\"count\":0,\"items\":[]}");
            ada.say("{'t':'perceive','id':1}").sync();
            room.step();
            long frame = ada.skipTo("perception").get("frame").longValue();
            assertThat(ask(eye, "ada").toString())
                    .isEqualTo(
                            "{\"everything\":false,\"frame\":"
                                    + frame
                                    + ",\"count\":2,\"items\":[\"duck\",\"ada\"]}");

            eye.say("{'t':'perceived','id':2,'client':'swan'}");
            assertThat(eye.skipTo("result").get("code").stringValue()).isEqualTo("no-such-agent");
            eye.say("{'t':'perceived','id':3,'client':'observer'}");
            assertThat(eye.skipTo("result").get("code").stringValue()).isEqualTo("no-such-agent");
            ada.say("{'t':'perceived','id':4,'client':'ada'}");
            assertThat(ada.skipTo("error").get("code").stringValue()).isEqualTo("not-permitted");
        }
    }

    @Test
    void itemsOutOfReachAreNotListed() throws IOException {
        room = seeing(1);
        try (TestClient ada = room.join("ada");
                TestClient boss = watcher(room, "control")) {
            ada.say("{'t':'perceive','id':1}").sync();
            room.step();
            ada.skipTo("perception");
            assertThat(ask(boss, "ada").get("items").toString()).isEqualTo("[\"ada\"]");
        }
    }

    @Test
    void anAgentWithoutSensorsPerceivesEverything() throws IOException {
        room = new AgentRoom();
        try (TestClient ada = room.join("ada");
                TestClient boss = watcher(room, "control")) {
            assertThat(ada.sync().hasNews()).isFalse();
            assertThat(ask(boss, "ada").toString()).isEqualTo("{\"everything\":true}");
        }
    }
}
