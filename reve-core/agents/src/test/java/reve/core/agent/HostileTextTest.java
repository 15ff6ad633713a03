// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import ch.qos.logback.classic.Logger;
import ch.qos.logback.classic.spi.ILoggingEvent;
import ch.qos.logback.core.read.ListAppender;

import org.junit.jupiter.api.Test;
import org.slf4j.LoggerFactory;

import reve.core.Seed;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.util.List;
import java.util.Random;

/** A text of a client can neither forge a log line nor hide a part of the output. */
class HostileTextTest {

    /** Number of texts. A long run uses a hundred thousand. */
    private static final int TEXTS = Integer.getInteger("reve.hostile.texts", 3_200);

    private static final int HELLOS = 200;
    private static final JsonMapper JSON = new JsonMapper();
    private static final List<String> PIECES =
            List.of(
                    "\0",
                    "\n",
                    "\r\n",
                    "\u001b[2J",
                    "\u0007",
                    "\u0085",
                    "\u2028",
                    "\u2029",
                    "\u202e",
                    "\u2066",
                    "\u200b",
                    "\ufeff",
                    "\u007f",
                    "\ue000",
                    "\t",
                    "ada",
                    " INFO reve.agents -- ",
                    "\"",
                    "\\",
                    "{}",
                    "%s",
                    "${jndi:x}",
                    "ä",
                    "\ud83e\udd86");

    private final long seed = Seed.of("hostile texts");
    private final Random random = new Random(seed);

    private String text() {
        var text = new StringBuilder();
        for (int i = random.nextInt(1, random.nextInt(20) == 0 ? 500 : 8); i > 0; i--) {
            text.append(PIECES.get(random.nextInt(PIECES.size())));
        }
        return JSON.writeValueAsString(text.toString());
    }

    /** Text for people contains no invisible character. */
    private void requireVisible(JsonNode message) {
        for (String field : List.of("reason", "message", "hint")) {
            message.path(field).asStringOpt().ifPresent(this::requireVisible);
        }
    }

    private void requireVisible(String text) {
        assertThat(
                        text.codePoints()
                                .filter(
                                        c ->
                                                switch (Character.getType(c)) {
                                                    case Character.CONTROL,
                                                            Character.FORMAT,
                                                            Character.LINE_SEPARATOR,
                                                            Character.PARAGRAPH_SEPARATOR,
                                                            Character.PRIVATE_USE,
                                                            Character.SURROGATE ->
                                                            true;
                                                    default -> false;
                                                })
                                .mapToObj(Integer::toHexString))
                .as("-Dreve.test.seed=%d: %s", seed, text)
                .isEmpty();
    }

    @Test
    void noTextOfAClientComesOutAsItCameIn() throws IOException {
        var log = new ListAppender<ILoggingEvent>();
        log.start();
        var logger = (Logger) LoggerFactory.getLogger("reve.agents");
        logger.addAppender(log);
        try (AgentRoom room = new AgentRoom()) {
            act(room);
            greet(room);
        } finally {
            logger.detachAppender(log);
        }
        assertThat(log.list).isNotEmpty();
        log.list.forEach(line -> requireVisible(line.getFormattedMessage()));
    }

    private void act(AgentRoom room) throws IOException {
        Parameter colour = Parameter.text("colour", "Which one.");
        room.world.add(
                ItemDefinition.named("sign")
                        .shape(Shape.sphere(1))
                        .action(
                                new DeclaredAction(
                                        "paint",
                                        "Paints it.",
                                        List.of(colour),
                                        List.of(
                                                new Effect.SetColour(
                                                        new Operand.Argument(colour)))))
                        .build());
        try (TestClient ada = room.join("ada")) {
            int atOnce = AgentRoom.CONFIG.limits().actsInFlight();
            for (int id = 0; id < TEXTS; id += atOnce) {
                for (int i = 0; i < atOnce; i++) {
                    String act =
                            switch (random.nextInt(5)) {
                                case 0 -> "\"item\":" + text() + ",\"action\":\"push\"";
                                case 1 -> "\"item\":\"duck\",\"action\":" + text();
                                case 2 ->
                                        "\"item\":\"duck\",\"action\":\"push\",\"arguments\":{"
                                                + text()
                                                + ":1}";
                                case 3 ->
                                        "\"item\":\"sign\",\"action\":\"paint\",\"arguments\":{\"colour\":"
                                                + text()
                                                + "}";
                                default ->
                                        "\"item\":\"duck\",\"action\":\"push\",\"arguments\":{\"impulse\":"
                                                + text()
                                                + "}";
                            };
                    ada.send(("{\"t\":\"act\",\"id\":" + (id + i) + "," + act + "}\n").getBytes());
                }
                ada.sync();
                room.step();
                for (int i = 0; i < atOnce; i++) {
                    JsonNode result = ada.expect("result");
                    assertThat(result.get("accepted").booleanValue()).isFalse();
                    requireVisible(result);
                }
            }
        }
    }

    private void greet(AgentRoom room) throws IOException {
        for (int i = 0; i < HELLOS; i++) {
            String field = List.of("name", "body", "role", "world", "encoding", "token").get(i % 6);
            String name = field.equals("name") ? "" : ",\"name\":\"eve\"";
            try (TestClient eve = room.connect()) {
                eve.send(
                        ("{\"t\":\"hello\",\"protocol\":1"
                                        + name
                                        + ",\""
                                        + field
                                        + "\":"
                                        + text()
                                        + "}\n")
                                .getBytes());
                if (field.equals("body") || field.equals("token")) {
                    room.stepUntil("eve is answered", eve::hasNews);
                }
                requireVisible(eve.next());
            }
        }
    }
}
