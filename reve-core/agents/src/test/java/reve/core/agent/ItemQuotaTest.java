// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.Subject;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.Shape;
import reve.core.world.SymbolBudget;
import reve.core.world.SymbolBytes;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.List;
import java.util.Map;
import java.util.stream.Collectors;
import java.util.stream.IntStream;
import java.util.stream.Stream;

/** The limit of items of agents' actions in a world, over the wire. */
class ItemQuotaTest {

    private static final int ITEMS = 4;
    private static final int WORLD_ITEMS = 6;
    private static final Parameter OLD = Parameter.item("old", "Which leaf.");
    private static final Effect LEAF =
            new Effect.Create(
                    ItemDefinition.named("leaf")
                            .shape(Shape.sphere(0.1))
                            .at(0, 2, 0)
                            .action(
                                    new DeclaredAction(
                                            "fall",
                                            "Goes.",
                                            List.of(),
                                            List.of(new Effect.Remove(Subject.ITEM))))
                            .build(),
                    Map.of());

    private static final Parameter TEXT = Parameter.text("text", "What the board says.");

    /** Number of symbols that one act sets. */
    private static final int SYMBOLS = 8;

    private static final int BOARDS = 400;

    /** Long texts cost more steps than a frame has for one of many agents. */
    private static final int FRAMES_OF_POST = 8;

    private AgentRoom room;
    private int id;

    @BeforeEach
    void open() throws IOException {
        var tree =
                ItemDefinition.named("tree")
                        .shape(Shape.box(1, 4, 1))
                        .action(
                                new DeclaredAction(
                                        "sprout", "Grows a leaf.", List.of(), List.of(LEAF)))
                        .action(
                                new DeclaredAction(
                                        "burst",
                                        "Grows three.",
                                        List.of(),
                                        List.of(LEAF, LEAF, LEAF)))
                        .action(
                                new DeclaredAction(
                                        "renew",
                                        "A leaf for a leaf.",
                                        List.of(OLD),
                                        List.of(new Effect.Remove(Subject.argument(OLD)), LEAF)))
                        .action(
                                new DeclaredAction(
                                        "double",
                                        "Two leaves for a leaf.",
                                        List.of(OLD),
                                        List.of(
                                                new Effect.Remove(Subject.argument(OLD)),
                                                LEAF,
                                                LEAF)));
        var boards =
                IntStream.range(0, BOARDS)
                        .mapToObj(i -> ItemDefinition.named("board " + i).action(post()).build());
        room =
                new AgentRoom(
                        AgentRoom.CONFIG,
                        AgentRoom.making().withItems(ITEMS, WORLD_ITEMS),
                        64,
                        Stream.concat(Stream.of(tree.build()), boards).toList());
    }

    private static DeclaredAction post() {
        return new DeclaredAction(
                "post",
                "Sets many symbols to one text.",
                List.of(TEXT),
                IntStream.range(0, SYMBOLS)
                        .<Effect>mapToObj(
                                i -> new Effect.SetSymbol("s" + i, new Operand.Argument(TEXT)))
                        .toList());
    }

    @AfterEach
    void close() {
        room.close();
    }

    /** Returns the code of a refusal; empty if the act was executed. */
    private String act(TestClient client, String item, String action, String arguments)
            throws IOException {
        client.say(
                        "{'t':'act','id':%d,'item':'%s','action':'%s','arguments':{%s}}"
                                .formatted(++id, item, action, arguments))
                .sync();
        int frames = action.equals("post") ? FRAMES_OF_POST : 1;
        for (int i = 0; i < frames; i++) {
            room.step();
        }
        JsonNode result = client.skipTo("result");
        return result.path("code").asString("");
    }

    private String sprout(TestClient client) throws IOException {
        return act(client, "tree", "sprout", "");
    }

    private void fill(TestClient client, int times) throws IOException {
        for (int i = 0; i < times; i++) {
            assertThat(sprout(client)).as("leaf %d", i + 1).isEmpty();
        }
    }

    /** Returns the oldest leaf of an agent that still exists. */
    private String leaf(String agent) {
        return room.world.items().stream()
                .filter(item -> item.maker().filter(agent::equals).isPresent())
                .findFirst()
                .orElseThrow()
                .name();
    }

    @Test
    void theWelcomeSaysBothQuotas() throws IOException {
        try (TestClient ada =
                room.connect().say("{'t':'hello','protocol':1,'name':'ada'}").sync()) {
            room.step();
            JsonNode limits = ada.expect("welcome").get("limits");
            assertThat(limits.get("items").intValue()).isEqualTo(ITEMS);
            assertThat(limits.get("worldItems").intValue()).isEqualTo(WORLD_ITEMS);
        }
    }

    @Test
    void whoHasAsManyItemsAsItMayCreatesNoMoreAndIsToldWhatThereIs() throws IOException {
        try (TestClient ada = room.join("ada")) {
            fill(ada, 2);
            assertThat(act(ada, "tree", "burst", ""))
                    .as("all of an action, or nothing")
                    .isEqualTo("too-many-items");
            assertThat(room.world.made("ada")).isEqualTo(2);
            fill(ada, 2);
            ada.say("{'t':'act','id':99,'item':'tree','action':'sprout'}").sync();
            room.step();
            assertThat(ada.skipTo("result"))
                    .isEqualTo(
                            TestClient.json(
                                    "{'t':'result','id':99,'accepted':false,'code':'too-many-items','reason':'the"
                                            + " action creates 1 item, and 4 of at most 4 items that"
                                            + " your actions created are in the world; remove some of"
                                            + " them first'}"));
        }
    }

    /** JSON needs six bytes for each control character. */
    @Test
    void textsOfActionsMakeNoWorldThatIsTooLargeToPerceive() throws IOException {
        String text = "\\u0001".repeat(1024);
        int posted = 0;
        int agents = 0;
        for (int own = 21; own == 21; agents++) { // until the room of all agents is used up
            try (TestClient each = room.join("agent-" + agents)) {
                for (own = 0; act(each, "board " + posted, "post", text(text)).isEmpty(); own++) {
                    posted++;
                }
            }
        }
        assertThat(agents).isEqualTo(16);
        assertThat(posted).isBetween(310, 320);
        assertThat(room.world.symbolBytes()).isBetween(14L << 20, SymbolBudget.OF_ALL);
        try (TestClient ada = room.join("ada")) {
            assertThat(act(ada, "board 390", "post", text(text))).isEqualTo("symbols-too-large");
            assertThat(act(ada, "board 390", "post", text("short"))).isEmpty();
            assertThat(act(ada, "board 0", "post", text("short"))).isEmpty();
            assertThat(act(ada, "board 390", "post", text(text))).isEmpty();
            assertThat(room.world.symbolBytes())
                    .isEqualTo(room.world.items().stream().mapToLong(SymbolBytes::of).sum());
        }
        assertEditsAreRefused(text);
        try (TestClient eve =
                room.connect()
                        .say("{'t':'hello','protocol':1,'name':'eve','role':'observer'}")
                        .sync()) {
            room.step();
            eve.say("{'t':'perceive','id':1}").sync();
            room.step();
            assertThat(eve.skipTo("perception").get("items").size()).isGreaterThan(BOARDS);
        }
    }

    private static String text(String value) {
        return "'text':'" + value + "'";
    }

    @Test
    void anAgentThatUsesItsRoomUpLeavesThatOfTheOthers() throws IOException {
        String text = "\\u0001".repeat(1024);
        try (TestClient ada = room.join("ada");
                TestClient bob = room.join("bob")) {
            for (int i = 0; i < 21; i++) {
                assertThat(act(ada, "board " + i, "post", text(text))).isEmpty();
            }
            ada.say(
                            "{'t':'act','id':999,'item':'board 22','action':'post','arguments':{%s}}"
                                    .formatted(text(text)))
                    .sync();
            for (int i = 0; i < FRAMES_OF_POST; i++) {
                room.step();
            }
            JsonNode refused = ada.skipTo("result");
            assertThat(refused.path("code").asString()).isEqualTo("symbols-too-large");
            assertThat(refused.path("reason").asString())
                    .contains("your actions have taken", "of their 1048576 bytes");
            assertThat(act(bob, "board 22", "post", text(text))).isEmpty();
            assertThat(act(ada, "board 1", "post", text("short"))).isEmpty();
            assertThat(act(ada, "board 23", "post", text(text)))
                    .as("a shortened text gives room back")
                    .isEmpty();
        }
    }

    /** Requires that no message of the role control gives an item 43 long symbols. */
    private void assertEditsAreRefused(String text) throws IOException {
        String item =
                "'semantic':{"
                        + IntStream.range(0, 43)
                                .mapToObj(i -> "'t" + i + "':'" + text.substring(0, 6 * 200) + "'")
                                .collect(Collectors.joining(","))
                        + "}";
        try (TestClient boss =
                room.connect()
                        .say("{'t':'hello','protocol':1,'name':'boss','role':'control'}")
                        .sync()) {
            room.step();
            int changes = 0;
            while (code(boss, change(changes, item)).isEmpty()) { // acts leave room for edits
                changes++;
            }
            assertThat(changes).isBetween(18, 22);
            long before = room.world.symbolBytes();
            int edits = 0;
            String edit =
                    "{'t':'edit','id':%d,'item':'tree','property':'semantic.t%d','value':'%s'}";
            while (code(boss, edit.formatted(edits + 1, edits, text)).isEmpty()) {
                edits++;
            }
            assertThat(code(boss, edit.formatted(199, edits, text))).isEqualTo("edit-refused");
            assertThat(code(boss, change(changes, item))).isEqualTo("edit-refused");
            assertThat(
                            code(
                                    boss,
                                    "{'t':'add','id':201,'items':[{'name':'more','semantic':{'t':'"
                                            + text
                                            + "'}}]}"))
                    .isEqualTo("edit-refused");
            String shorter =
                    "{'t':'change','item':'board 0','to':{'semantic':{'s0':'x'}}},".repeat(30);
            String longer = "{'name':'more %d','semantic':{'t':'" + text + "'}}";
            assertThat(
                            code(
                                    boss,
                                    "{'t':'batch','id':202,'changes':["
                                            + shorter
                                            + "{'t':'add','items':["
                                            + longer.formatted(1)
                                            + ","
                                            + longer.formatted(2)
                                            + "]}]}"))
                    .as("a symbol that is shortened again and again gives no room")
                    .isEqualTo("edit-refused");
            String none =
                    IntStream.range(0, edits)
                            .mapToObj(i -> "'t" + i + "':null")
                            .collect(Collectors.joining(","));
            assertThat(
                            code(
                                    boss,
                                    "{'t':'change','id':300,'item':'tree','to':{'semantic':{"
                                            + none
                                            + "}}}"))
                    .isEmpty();
            assertThat(room.world.symbolBytes()).isEqualTo(before);
        }
    }

    private String change(int board, String item) {
        return "{'t':'change','id':%d,'item':'board %d','to':{%s}}"
                .formatted(400 + board, board, item);
    }

    private String code(TestClient client, String message) throws IOException {
        client.say(message).sync();
        room.step();
        return client.skipTo("result").path("code").asString("");
    }

    @Test
    void anItemThatWasRemovedGivesItsPlaceBack() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient bob = room.join("bob")) {
            fill(ada, ITEMS);
            assertThat(act(bob, leaf("ada"), "fall", "")).isEmpty();
            fill(ada, 1);
            assertThat(sprout(ada)).isEqualTo("too-many-items");
            assertThat(act(ada, "tree", "renew", "'old':'" + leaf("ada") + "'"))
                    .as("one for one")
                    .isEmpty();
            assertThat(act(ada, "tree", "double", "'old':'" + leaf("ada") + "'"))
                    .as("two for one")
                    .isEqualTo("too-many-items");
            assertThat(room.world.made("ada")).isEqualTo(ITEMS);
        }
    }

    @Test
    void theQuotaOfTheWorldHoldsForAllTogetherAndForAnotherName() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient bob = room.join("bob")) {
            fill(ada, ITEMS);
            fill(bob, WORLD_ITEMS - ITEMS);
            assertThat(sprout(bob)).isEqualTo("too-many-items");
            assertThat(act(bob, "tree", "renew", "'old':'" + leaf("ada") + "'"))
                    .as("one for one of another agent")
                    .isEmpty();
            assertThat(room.world.made("ada")).isEqualTo(ITEMS - 1);
            assertThat(room.world.made("bob")).isEqualTo(WORLD_ITEMS - ITEMS + 1);
            assertThat(room.world.made()).isEqualTo(WORLD_ITEMS);
        }
    }

    @Test
    void whoComesBackUnderItsNameFindsItsItemsCounted() throws IOException {
        try (TestClient ada = room.join("ada")) {
            fill(ada, ITEMS);
            ada.say("{'t':'bye'}");
            ada.skipToBye("goodbye");
        }
        room.stepUntil("ada has left", () -> !room.has("ada"));
        try (TestClient ada = room.join("ada")) {
            assertThat(sprout(ada)).isEqualTo("too-many-items");
        }
    }

    @Test
    void aRewindTakesTheCountBackWithTheItems() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}").expect("welcome");
            fill(ada, 1);
            boss.say("{'t':'snapshot','id':1,'image':'young'}").sync();
            room.step();
            fill(ada, ITEMS - 1);
            assertThat(sprout(ada)).isEqualTo("too-many-items");
            boss.say("{'t':'rewind','id':2,'image':'young'}").sync();
            room.step();
            assertThat(room.world.made("ada")).isEqualTo(1);
            assertThat(room.world.made()).isEqualTo(1);
            fill(ada, ITEMS - 1);
            assertThat(sprout(ada)).isEqualTo("too-many-items");
        }
    }
}
