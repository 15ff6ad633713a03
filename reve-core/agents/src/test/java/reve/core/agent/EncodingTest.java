// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.audit.AuditPlan;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.MessagePackReader;
import reve.core.agent.protocol.MessageWriter;

import tools.jackson.databind.JsonNode;

import java.io.DataInputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** MessagePack over a real socket, and the audit record. */
class EncodingTest {

    @TempDir private Path folder;
    private AgentRoom room;

    @BeforeEach
    void open() throws IOException {
        room =
                new AgentRoom(
                        AgentRoom.CONFIG.withAudit(AuditPlan.of(folder.resolve("audit.jsonl"))));
    }

    @AfterEach
    void close() {
        room.close();
    }

    /** A client that sends hello in JSON and continues in MessagePack. */
    private final class Packed implements AutoCloseable {
        private final Socket socket;
        private final OutputStream out;
        private final DataInputStream in;

        Packed(String name) throws IOException {
            socket =
                    new Socket(room.server.address().getAddress(), room.server.address().getPort());
            socket.setSoTimeout(300_000);
            out = socket.getOutputStream();
            in = new DataInputStream(socket.getInputStream());
            out.write(
                    ("{\"t\":\"hello\",\"protocol\":1,\"encoding\":\"msgpack\",\"name\":\""
                                    + name
                                    + "\"}\n")
                            .getBytes(StandardCharsets.US_ASCII));
        }

        Packed say(String json) throws IOException {
            JsonNode message = TestClient.json(json);
            byte[] packed = Encoding.MESSAGEPACK.value(writer -> write(writer, message));
            out.write(
                    ByteBuffer.allocate(4 + packed.length)
                            .putInt(packed.length)
                            .put(packed)
                            .array());
            return this;
        }

        private static void write(MessageWriter writer, JsonNode node) {
            if (node.isObject()) {
                writer.beginMap(node.size());
                node.properties()
                        .forEach(
                                field -> {
                                    writer.key(field.getKey());
                                    write(writer, field.getValue());
                                });
            } else if (node.isArray()) {
                writer.beginList(node.size());
                node.forEach(element -> write(writer, element));
            } else if (node.isNumber()) {
                writer.number(node.doubleValue());
            } else {
                writer.text(node.stringValue());
            }
        }

        JsonNode next() throws IOException {
            byte[] message = new byte[in.readInt()];
            in.readFully(message);
            return MessagePackReader.read(ByteBuffer.wrap(message));
        }

        JsonNode expect(String type) throws IOException {
            JsonNode message = next();
            assertThat(message.get("t").stringValue()).as("%s", message).isEqualTo(type);
            return message;
        }

        @Override
        public void close() throws IOException {
            socket.close();
        }
    }

    @Test
    void theExampleSessionIsTheSameInMessagePack() throws IOException {
        try (Packed client = new Packed("ada")) {
            room.stepUntil("it has come in", () -> room.has("ada"));
            assertThat(client.expect("welcome").get("encoding").stringValue()).isEqualTo("msgpack");
            client.expect("event");
            client.say("{'t':'perceive','id':1,'every':1}").say("{'t':'ping','id':2}");
            assertThat(client.expect("pong").get("id").longValue()).isEqualTo(2);
            room.step();
            JsonNode first = client.expect("perception");
            assertThat(first.at("/items/0/symbols/class").stringValue()).isEqualTo("toy");
            assertThat(first.at("/items/0/location/2").doubleValue()).isEqualTo(-2.5);
            client.say(
                            "{'t':'act','id':3,'item':'duck','action':'push',"
                                    + "'arguments':{'impulse':[0.5,0,0]}}")
                    .say("{'t':'ping','id':4}");
            client.expect("pong");
            room.item("duck").physical().setLocation(2, 0, 0);
            room.step();
            assertThat(client.expect("result").get("accepted").booleanValue()).isTrue();
            client.expect("event");
            JsonNode second = client.expect("perception");
            assertThat(second.get("since")).isEqualTo(first.get("frame"));
            assertThat(second.get("changed").toString())
                    .isEqualTo("[{\"name\":\"duck\",\"location\":[2.0,0.0,0.0]}]");
            client.say("{'t':'bye'}");
            assertThat(client.expect("bye").get("code").stringValue()).isEqualTo("goodbye");
        }
    }

    @Test
    void aMessageLongerThanTheLimitIsCutBeforeItIsKept() throws IOException {
        try (Packed client = new Packed("ada")) {
            room.stepUntil("it has come in", () -> room.has("ada"));
            client.expect("welcome");
            client.expect("event");
            client.out.write(new byte[] {0x7f, 0, 0, 0, 1, 2, 3});
            assertThat(client.expect("bye").get("code").stringValue()).isEqualTo("line-too-long");
        }
    }

    @Test
    void anEncodingThatTheServerDoesNotWriteIsRefusedInJson() throws IOException {
        try (TestClient client = room.connect()) {
            client.say("{'t':'hello','protocol':1,'name':'ada','encoding':'xml'}")
                    .expectBye("encoding-unsupported");
        }
    }

    @Test
    void theRecordHoldsExactlyWhatEachClientWasToldInBothEncodings() throws IOException {
        var told = new ArrayList<JsonNode>();
        try (Packed ada = new Packed("ada");
                TestClient bob = room.connect()) {
            room.stepUntil("ada has come in", () -> room.has("ada"));
            bob.say("{'t':'hello','protocol':1,'name':'bob'}").sync();
            room.step();
            ada.say("{'t':'perceive','id':1}").say("{'t':'ping','id':2}");
            for (int i = 0; i < 4; i++) { // welcome, two joined, pong
                told.add(ada.next());
            }
            room.step();
            told.add(ada.expect("perception"));
            bob.expect("welcome");
            ada.say("{'t':'bye'}");
            told.add(ada.expect("bye"));
        }
        room.server.close();
        List<JsonNode> record =
                Files.readAllLines(folder.resolve("audit.jsonl")).stream()
                        .map(TestClient::json)
                        .toList();
        assertThat(record)
                .allSatisfy(entry -> assertThat(entry.get("at").stringValue()).startsWith("20"));
        assertThat(record)
                .allSatisfy(
                        entry -> assertThat(entry.get("world").stringValue()).isEqualTo("pond"));
        assertThat(
                        record.stream()
                                .filter(entry -> entry.get("client").stringValue().equals("ada"))
                                .map(entry -> entry.get("message").toString()))
                .containsExactlyElementsOf(told.stream().map(JsonNode::toString).toList());
        assertThat(
                        record.stream()
                                .anyMatch(entry -> entry.get("client").stringValue().equals("bob")))
                .isTrue();
    }
}
