// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.Terms;
import reve.core.rule.Expression;
import reve.core.rule.Scope;
import reve.core.world.ItemDefinition;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/** The effect of costly acts on other agents, over the wire. */
class DearActsTest {

    private static final int IN_FLIGHT = 60;

    /** An expression that takes about 900 rounds. */
    private static final String DEAR =
            IntStream.range(0, 30)
                            .mapToObj(Integer::toString)
                            .collect(Collectors.joining(",", "[", "]"))
                    + ".all(a, "
                    + IntStream.range(0, 29)
                            .mapToObj(Integer::toString)
                            .collect(Collectors.joining(",", "[", "]"))
                    + ".all(b, a + b + a * b >= 0))";

    /** Texts that have 8,000 characters together. */
    private static final List<String> PAGES =
            IntStream.range(0, 8).mapToObj(i -> "x".repeat(1000)).toList();

    private AgentRoom room;

    @BeforeEach
    void open() throws Exception {
        Expression dear =
                Scope.ofAction(WorldPrototype.standard("si-f64"), WorldPrototype.BODY, List.of())
                        .compile(DEAR);
        var oracle =
                ItemDefinition.named("oracle")
                        .shape(Shape.box(1, 2, 1))
                        .action(
                                new DeclaredAction(
                                        "ask",
                                        "Thinks for long.",
                                        List.of(),
                                        new Terms(List.of(), List.of(dear)),
                                        List.of(
                                                new Effect.SetSymbol(
                                                        "asked", new Operand.Symbol(true)))))
                        .action(
                                new DeclaredAction(
                                        "greet",
                                        "Does not think.",
                                        List.of(),
                                        List.of(
                                                new Effect.SetSymbol(
                                                        "greeted", new Operand.Symbol(true)))))
                        .action(
                                new DeclaredAction(
                                        "write",
                                        "Writes texts that every client receives.",
                                        List.of(),
                                        List.of(
                                                new Effect.SetSymbol(
                                                        "pages", new Operand.Symbol(PAGES)))));
        room = new AgentRoom(AgentRoom.CONFIG, AgentRoom.making(), 4096, List.of(oracle.build()));
    }

    @AfterEach
    void close() {
        room.close();
    }

    private static void act(TestClient client, int id, String action) throws IOException {
        client.say("{'t':'act','id':%d,'item':'oracle','action':'%s'}".formatted(id, action));
    }

    /** Returns the number of executed acts in each frame, once that many have results. */
    private Map<Long, Integer> frames(TestClient client, int acts) throws IOException {
        var frames = new HashMap<Long, Integer>();
        for (int i = 0; i < acts; i++) {
            JsonNode result = client.skipTo("result");
            assertThat(result.get("id").intValue()).as("order").isEqualTo(i + 1);
            assertThat(result.get("accepted").booleanValue()).as("%s", result).isTrue();
            frames.merge(result.get("frame").longValue(), 1, Integer::sum);
        }
        return frames;
    }

    @Test
    void anAgentsDearActsAreSpreadOverFramesAndKeepTheirOrder() throws IOException {
        try (TestClient ada = room.join("ada")) {
            for (int id = 1; id <= IN_FLIGHT; id++) {
                act(ada, id, "ask");
            }
            ada.sync();
            for (int i = 0; i < IN_FLIGHT; i++) {
                room.step();
            }
            assertThat(frames(ada, IN_FLIGHT).values()).allMatch(count -> count <= 3);
        }
    }

    @Test
    void actsThatWriteLongTextsAreSpreadOverFrames() throws IOException {
        try (TestClient ada = room.join("ada")) {
            for (int id = 1; id <= IN_FLIGHT; id++) {
                act(ada, id, "write");
            }
            ada.sync();
            for (int i = 0; i < IN_FLIGHT; i++) {
                room.step();
            }
            assertThat(frames(ada, IN_FLIGHT).values()).allMatch(count -> count <= 3);
        }
    }

    @Test
    void cheapActsOfAnotherAgentAreDoneAtOnce() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient zoe = room.join("zoe")) {
            for (int id = 1; id <= IN_FLIGHT; id++) {
                act(ada, id, "ask");
            }
            ada.sync();
            room.step();
            for (int id = 1; id <= 5; id++) {
                act(zoe, id, "greet");
            }
            zoe.sync();
            room.step();
            assertThat(frames(zoe, 5)).containsExactly(Map.entry(room.loop.frame(), 5));
        }
    }

    @Test
    void whoLeavesIsGoneWhenItsActsAreDone() throws IOException {
        try (TestClient bob = room.join("bob")) {
            try (TestClient ada = room.join("ada")) {
                for (int id = 1; id <= IN_FLIGHT; id++) {
                    act(ada, id, "ask");
                }
                ada.sync().say("{'t':'bye'}");
                ada.skipTo("bye");
            }
            room.stepUntil("ada's body is gone", () -> !room.has("ada"));
            bob.say("{'t':'perceive','id':1}").sync();
            room.step();
            assertThat(bob.skipTo("perception").toString()).contains("\"asked\":true");
        }
    }
}
