// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.Optional;

/** Round-trip times of clients in the report {@code state}. */
class RoundTripReportTest {
    private AgentRoom room;
    private TestClient ada;

    @BeforeEach
    void join() throws IOException {
        room = new AgentRoom();
        ada = room.join("ada");
    }

    @AfterEach
    void leave() throws IOException {
        ada.close();
        room.close();
    }

    private TestClient watcher(String role) throws IOException {
        TestClient client = room.connect();
        client.say("{'t':'hello','protocol':1,'name':'eve','role':'" + role + "'}");
        client.expect("welcome");
        return client;
    }

    private Optional<Double> roundTrip(TestClient asker, int id, String fields) throws IOException {
        asker.say("{'t':'state','id':" + id + fields + "}").sync();
        room.step();
        for (JsonNode client : asker.skipTo("report").at("/content/clients")) {
            if (client.get("name").stringValue().equals("ada")) {
                return client.optional("roundTripSeconds").map(JsonNode::doubleValue);
            }
        }
        throw new AssertionError("ada is not in the report");
    }

    @Test
    void theRoleControlMeasuresTheTimeUntilAClientAnswersAPing() throws IOException {
        try (TestClient boss = watcher("control")) {
            assertThat(roundTrip(boss, 1, "")).isEmpty();
            assertThat(ada.sync().hasNews()).isFalse();

            assertThat(roundTrip(boss, 2, ",'roundTrips':true")).isEmpty();
            ada.skipTo("ping");
            ada.say("{'t':'pong'}").sync();
            assertThat(roundTrip(boss, 3, "").orElseThrow()).isPositive();
        }
    }

    @Test
    void anObserverSeesTheTimesButSendsNoPings() throws IOException {
        try (TestClient eve = watcher("observer")) {
            eve.say("{'t':'state','id':1,'roundTrips':true}");
            JsonNode refused = eve.skipTo("result");
            assertThat(refused.get("code").stringValue()).isEqualTo("not-permitted");
            assertThat(refused.get("reason").stringValue()).contains("role control");
            assertThat(ada.sync().hasNews()).isFalse();
            assertThat(roundTrip(eve, 2, "")).isEmpty();
        }
    }
}
