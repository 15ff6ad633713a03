// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.ArrayList;
import java.util.List;

/** The report of the items whose names or symbols contain a text. */
class SearchReportTest {
    private AgentRoom room;
    private TestClient eye;

    @BeforeEach
    void join() throws IOException {
        List<ItemDefinition> items = new ArrayList<>(List.of(AgentRoom.duck()));
        items.add(
                ItemDefinition.named("Swan")
                        .symbol("temper", "lively")
                        .symbol("worn", true)
                        .build());
        for (int i = 0; i < 120; i++) {
            items.add(ItemDefinition.named("pebble-" + i).build());
        }
        room = new AgentRoom(AgentRoom.CONFIG, AgentRoom.making(), 64, items);
        room.step();
        eye = room.connect();
        eye.say("{'t':'hello','protocol':1,'name':'eye','role':'observer'}");
        eye.expect("welcome");
    }

    @AfterEach
    void leave() throws IOException {
        eye.close();
        room.close();
    }

    private JsonNode search(String text) throws IOException {
        eye.say("{'t':'search','id':1,'text':'" + text + "'}");
        return eye.skipTo("report").get("content");
    }

    @Test
    void itemsAreFoundByNamesAndBySymbolsInAnyCase() throws IOException {
        String swan = "{\"count\":1,\"items\":[{\"name\":\"Swan\",\"symbols\":%s}]}";
        assertThat(search("TOY").toString())
                .isEqualTo(
                        "{\"count\":1,\"items\":[{\"name\":\"duck\",\"symbols\":{\"class\":\"toy\"}}]}");
        assertThat(search("live").toString()).isEqualTo(swan.formatted("{\"temper\":\"lively\"}"));
        assertThat(search("ORN").toString()).isEqualTo(swan.formatted("{\"worn\":true}"));
        assertThat(search("sWA").toString()).isEqualTo(swan.formatted("{}"));
        assertThat(search("goose").toString()).isEqualTo("{\"count\":0,\"items\":[]}");
    }

    @Test
    void aTextOfMoreThanAThousandCharactersIsRefused() throws IOException {
        assertThat(search("x".repeat(1000)).get("count").intValue()).isZero();
        eye.say("{'t':'search','id':2,'text':'" + "x".repeat(1001) + "'}");
        JsonNode refused = eye.skipTo("result");
        assertThat(refused.get("code").stringValue()).isEqualTo("too-large");
        assertThat(refused.get("reason").stringValue())
                .isEqualTo("the text has 1001 characters, at most 1000 are allowed");
    }

    /**
     * Queries that wait are dropped, so that they do not count as waiting when the client is back.
     */
    @Test
    void queriesOfALostConnectionAreDropped() throws IOException {
        TestClient first = room.connect();
        first.say("{'t':'hello','protocol':1,'name':'far','role':'observer','graceSeconds':60}");
        JsonNode welcome = first.expect("welcome");
        int most = AgentRoom.CONFIG.limits().actsInFlight();
        for (int id = 1; id <= most; id++) {
            first.say("{'t':'state','id':" + id + "}"); // waits for the next frame
        }
        first.sync();
        first.close();
        TestClient back = room.connect();
        back.say(
                "{'t':'hello','protocol':1,'name':'far','role':'observer','resume':{'session':'"
                        + welcome.at("/session/token").stringValue()
                        + "','frame':0}}");
        back.expect("welcome");
        back.say("{'t':'state','id':" + (most + 1) + "}");
        back.sync();
        room.step();
        assertThat(back.skipTo("report").get("id").intValue()).isEqualTo(most + 1);
        back.close();
    }

    @Test
    void aReportListsAtMostAHundredItems() throws IOException {
        JsonNode found = search("pebble");
        assertThat(found.get("count").intValue()).isEqualTo(120);
        assertThat(found.get("items")).hasSize(100);
    }
}
