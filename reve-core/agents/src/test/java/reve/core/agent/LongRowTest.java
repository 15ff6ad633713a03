// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Json;
import reve.core.agent.protocol.MessagePackReader;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.BufferedInputStream;
import java.io.DataInputStream;
import java.io.IOException;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

import javax.net.SocketFactory;

/**
 * Two threads write if there are many clients. Then each client receives the same data as a client
 * that is alone.
 */
class LongRowTest {

    private static final int AGENTS = 180;
    private static final int OBSERVERS = 24;
    private static final int THINGS = 12;
    private static final int FRAMES = 24;

    @TempDir private static Path folder;

    @Test
    void everybodyIsToldWhereThingsAre() throws IOException {
        toldWhereThingsAre(AgentRoom.CONFIG, SocketFactory.getDefault());
    }

    @Test
    void everybodyIsToldWhereThingsAreOverTls() throws Exception {
        Certificate certificate = Certificate.make(folder, "server");
        AgentServerConfig c = AgentRoom.CONFIG;
        var security = new AgentSecurity(Optional.empty(), Optional.of(certificate.tls()));
        toldWhereThingsAre(
                new AgentServerConfig(c.address(), c.limits(), c.timeouts(), c.audit(), security),
                certificate.trusting().getSocketFactory());
    }

    private static void toldWhereThingsAre(AgentServerConfig config, SocketFactory sockets)
            throws IOException {
        try (AgentRoom room = room(config)) {
            List<Watcher> watchers = watchers(room, sockets);
            for (int frame = 0; frame < FRAMES; frame++) {
                move(room);
                for (Watcher watcher : watchers) {
                    watcher.perceive(room);
                }
            }
            for (Watcher watcher : watchers) {
                watcher.socket.close();
            }
        }
    }

    @Test
    void whoIsGoneInTheMiddleOfARowIsLetGoAndTheOthersAreTold() throws IOException {
        try (AgentRoom room = room(AgentRoom.CONFIG)) {
            List<Watcher> watchers = watchers(room, SocketFactory.getDefault());
            List<Watcher> staying = new ArrayList<>();
            for (Watcher watcher : watchers) {
                if (watcher.number % 2 == 0) {
                    staying.add(watcher);
                } else {
                    watcher.socket.setSoLinger(true, 0); // its end is a reset
                    watcher.socket.close();
                }
            }
            for (int frame = 0; frame < FRAMES; frame++) {
                move(room);
                for (Watcher watcher : staying) {
                    watcher.perceive(room);
                }
            }
            room.stepUntil(
                    "only those who stay are left",
                    () -> room.server.stats().open() == staying.size());
            for (Watcher watcher : staying) {
                watcher.socket.close();
            }
        }
    }

    private static AgentRoom room(AgentServerConfig config) throws IOException {
        var bodies = new ArrayList<String>();
        var items = new ArrayList<ItemDefinition>();
        for (int i = 0; i < AGENTS; i++) {
            bodies.add("agent-" + i);
            items.add(
                    ItemDefinition.named("agent-" + i)
                            .at(0, 100 * i, 0)
                            .sensor(Sensor.sight("eyes", 1e6))
                            .build());
        }
        for (int i = 0; i < THINGS; i++) {
            items.add(
                    ItemDefinition.named("thing-" + i)
                            .shape(Shape.sphere(0.5))
                            .at(i, 0, 0)
                            .build());
        }
        return new AgentRoom(config, new AgentPolicy(bodies, Optional.empty()), 1024, items);
    }

    /** Makes a frame in which each item except the last is at a place where no item was before. */
    private static void move(AgentRoom room) {
        long next = room.loop.frame() + 1;
        for (int i = 0; i < THINGS - 1; i++) {
            room.item("thing-" + i).physical().setLocation(i, 0, next);
        }
        room.step();
    }

    private static List<Watcher> watchers(AgentRoom room, SocketFactory sockets)
            throws IOException {
        var watchers = new ArrayList<Watcher>();
        for (int i = 0; i < AGENTS + OBSERVERS; i++) {
            watchers.add(
                    new Watcher(
                            i,
                            sockets.createSocket(
                                    room.server.address().getAddress(),
                                    room.server.address().getPort())));
        }
        room.stepUntil("all agents are there", () -> room.server.stats().agents() == AGENTS);
        for (Watcher watcher : watchers) {
            watcher.ask();
        }
        return watchers;
    }

    /** Perceives every frame, or every second or third; half of the clients use MessagePack. */
    private static final class Watcher {

        private final int number;
        private final int every;
        private final Encoding encoding;
        private final Socket socket;
        private final DataInputStream in;
        private final Map<String, Double> places = new HashMap<>();
        private long frame = -1;

        Watcher(int number, Socket socket) throws IOException {
            this.number = number;
            this.every = 1 + number % 3;
            this.encoding = number / 2 % 2 == 0 ? Encoding.JSON : Encoding.MESSAGEPACK;
            this.socket = socket;
            socket.setTcpNoDelay(true);
            socket.setSoTimeout(300_000);
            this.in = new DataInputStream(new BufferedInputStream(socket.getInputStream()));
            var hello =
                    new LinkedHashMap<String, Object>(
                            Map.of(
                                    "t",
                                    "hello",
                                    "protocol",
                                    1,
                                    "name",
                                    "agent-" + number,
                                    "encoding",
                                    encoding.wireName()));
            if (number >= AGENTS) {
                hello.put("role", "observer");
            }
            say(hello, Encoding.JSON);
        }

        private void say(Map<String, Object> message, Encoding how) throws IOException {
            var out = new Bytes();
            byte[] body = how.value(writer -> writer.value(message));
            if (how == Encoding.JSON) {
                out.put(body).put('\n');
            } else {
                out.putInt(body.length).put(body);
            }
            socket.getOutputStream().write(out.toArray());
        }

        /** Requests perceptions, and returns when the server has read the request. */
        void ask() throws IOException {
            while (!type(read()).equals("welcome")) {
                // Skips events about other agents.
            }
            say(Map.of("t", "perceive", "every", every), encoding);
            say(Map.of("t", "ping"), encoding);
            while (!type(read()).equals("pong")) {
                // Skips perceptions. Until now, the world was empty.
            }
        }

        /** Reads the perception of the last frame; then the client knows all positions. */
        void perceive(AgentRoom room) throws IOException {
            while (frame + every <= room.loop.frame()) {
                take(read());
            }
            var expected = new HashMap<String, Double>();
            for (int i = 0; i < THINGS; i++) {
                expected.put("thing-" + i, i == THINGS - 1 ? 0.0 : (double) frame);
            }
            assertThat(places)
                    .as("what %d perceives in frame %d", number, frame)
                    .isEqualTo(expected);
        }

        private void take(JsonNode message) {
            if (type(message).equals("perception")) {
                frame = message.get("frame").longValue();
                for (String list : List.of("items", "entered", "changed")) {
                    for (JsonNode item : message.path(list)) {
                        String name = item.get("name").stringValue();
                        if (name.startsWith("thing")) {
                            places.put(name, item.get("location").get(2).doubleValue());
                        }
                    }
                }
            }
        }

        private static String type(JsonNode message) {
            return message.get("t").stringValue();
        }

        private JsonNode read() throws IOException {
            if (encoding == Encoding.MESSAGEPACK) {
                byte[] message = new byte[in.readInt()];
                in.readFully(message);
                return MessagePackReader.read(ByteBuffer.wrap(message));
            }
            var line = new Bytes();
            for (int octet = in.readUnsignedByte(); octet != '\n'; octet = in.readUnsignedByte()) {
                line.put(octet);
            }
            return Json.MAPPER.readTree(line.toArray());
        }
    }
}
