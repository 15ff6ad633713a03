// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.agent.Perception;
import reve.agent.WorldEvent;
import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.concurrent.TimeUnit;

/** A node that only watches shows the worlds of other nodes to observers. */
@Tag("slow")
class ClusterWatchIT {
    private static final JsonMapper JSON = new JsonMapper();

    @TempDir private Path folder;
    private final List<Server> servers = new ArrayList<>();
    private Postgres postgres;
    private String url;

    /**
     * @param address where other nodes reach it
     * @param agents port for agents
     */
    private record Node(Server server, String address, int agents) {}

    @BeforeEach
    void start() throws Exception {
        postgres = new Postgres();
        url = postgres.create("watch");
    }

    @AfterEach
    void end() throws Exception {
        servers.forEach(Server::close);
        postgres.close();
    }

    private Node node(String... more) throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "serve",
                                "--cluster",
                                "lab",
                                "--port",
                                "0",
                                "--json",
                                "--store",
                                url));
        arguments.addAll(List.of(more));
        Server server =
                Server.start(
                        Files.createDirectory(folder.resolve("node" + servers.size())),
                        arguments.toArray(String[]::new));
        servers.add(server);
        JsonNode starts =
                server.events()
                        .await(
                                "cluster",
                                event -> event.path("status").asString().equals("starts"));
        return new Node(server, starts.path("node").asString(), starts.path("agentPort").asInt());
    }

    private static void awaitUp(Node at, Node other) throws IOException {
        at.server()
                .events()
                .await(
                        "cluster",
                        event ->
                                event.path("status").asString().equals("up")
                                        && event.path("node").asString().equals(other.address()));
    }

    /** Says hello in a new connection, and returns the answer. */
    private static JsonNode hello(Node node, String role) throws IOException {
        try (Socket socket = new Socket("127.0.0.1", node.agents());
                var in =
                        new BufferedReader(
                                new InputStreamReader(
                                        socket.getInputStream(), StandardCharsets.UTF_8))) {
            String line =
                    "{\"t\":\"hello\",\"protocol\":1,\"name\":\"visitor\",\"role\":\""
                            + role
                            + "\"}\n";
            socket.getOutputStream().write(line.getBytes(StandardCharsets.UTF_8));
            return JSON.readTree(in.readLine());
        }
    }

    /** Says hello until the answer has this code. */
    private static JsonNode awaitHello(Node node, String role, String code)
            throws IOException, InterruptedException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(120);
        while (true) {
            JsonNode answer = hello(node, role);
            if (answer.path("code").asString("").equals(code)) {
                return answer;
            }
            assertThat(System.nanoTime()).as("%s", answer).isLessThan(end);
            Thread.sleep(200);
        }
    }

    private static Join observer(String name) {
        return Join.as(name).withRole("observer");
    }

    private static Set<String> awaitEvents(AgentClient client, String last) {
        Set<String> types = new HashSet<>();
        while (!types.contains(last)) {
            client.perceive();
            client.events().stream().map(WorldEvent::type).forEach(types::add);
        }
        return types;
    }

    /** Returns the first perception of this frame or a later one. */
    private static Perception next(AgentClient client, long frame) {
        Perception perception = client.nextPerception();
        while (perception.frame() < frame) {
            perception = client.nextPerception();
        }
        return perception;
    }

    private static JsonNode status(Node node) throws Exception {
        Outcome told =
                Reve.run("cluster", "status", "--port", Integer.toString(node.agents()), "--json");
        assertThat(told.code()).as(told.err()).isZero();
        return JSON.readTree(told.out());
    }

    @Test
    void observersPerceiveACopyThatEqualsTheWorld() throws Exception {
        Node owner = node(Project.WORLDS.resolve("spring-orbit").toString(), "--sleep-after", "3");
        Node watching = node("--seed", owner.address(), "--watch");
        awaitUp(owner, watching);
        JsonNode sent = awaitHello(owner, "observer", "moved");
        assertThat(sent.toString()).contains("127.0.0.1:" + watching.agents());
        assertThat(awaitHello(watching, "agent", "moved").toString())
                .contains("127.0.0.1:" + owner.agents());

        try (AgentClient observer = Agents.join(owner.agents(), observer("eve"));
                AgentClient control =
                        Agents.join(watching.agents(), Join.as("chef").withRole("control"))) {
            JsonNode nodes = status(owner).path("nodes");
            assertThat(
                            nodes.valueStream()
                                    .filter(each -> each.path("watching").asBoolean())
                                    .map(each -> each.path("node").asString()))
                    .containsExactly(watching.address());

            AgentClient agent = Agents.join(watching.agents(), Join.as("ada"));
            assertThat(agent.act("red", "paint", Map.of("colour", "#00ff00")).accepted()).isTrue();
            assertThat(awaitEvents(observer, "acted")).contains("joined");

            control.perceiveEvery(1);
            observer.perceiveEvery(1);
            control.nextPerception(); // a paused world begins no stream of perceptions
            observer.nextPerception();
            long paused = control.command("pause", Map.of()).frame().orElseThrow();
            Perception original = next(control, paused);
            Perception copy = next(observer, paused);
            assertThat(copy.frame()).isEqualTo(original.frame());
            assertThat(copy.time()).isEqualTo(original.time());
            assertThat(copy.items().toString()).isEqualTo(original.items().toString());
            assertThat(copy.find("red").orElseThrow().symbols()).containsEntry("painted", true);
            assertThat(copy.find("ada")).isPresent();
            assertThat(observer.report("inspect", Map.of("item", "red")).content().toString())
                    .isEqualTo(
                            control.report("inspect", Map.of("item", "red")).content().toString());
            control.stopPerceiving();
            observer.stopPerceiving();
            control.command("run", Map.of());

            agent.close();
            awaitEvents(observer, "left");
            assertThat(observer.perceive().find("ada")).isEmpty();
            control.command("rewind", Map.of());
            awaitEvents(observer, "rewound");
            assertThat(observer.perceive().find("red").orElseThrow().symbols())
                    .doesNotContainKey("painted");
        }
        owner.server().events().await("world-asleep", _ -> true);
    }

    @Test
    void observersStayConnectedWhenTheOwnerIsLost() throws Exception {
        Path crowd = folder.resolve("crowd.yaml"); // its frames need several parts of a stream
        Files.writeString(
                crowd,
                """
                reve: 1
                name: crowd
                frame: {rate: 20, steps: 1}
                laws: [newton_motion]
                agents:
                  body: {physical: {shape: sphere, radius: 0.1}}
                items:
                  - name: ball-{i}
                    repeat: 2000
                    physical: {shape: sphere, radius: 0.1, location: "{[i, 1, 0]}"}
                    physics: {mass: 1 kg, velocity: [0.01, 0.02, 0.03]}
                """);
        Node owner = node(crowd.toString());
        Node watching = node("--seed", owner.address(), "--watch");
        awaitUp(owner, watching);
        Join ada = Join.as("ada").withGrace(Duration.ofMinutes(1));
        try (AgentClient observer = Agents.join(watching.agents(), observer("eve"));
                AgentClient agent = Agents.join(owner.agents(), ada)) {
            Perception seen = observer.perceive();
            long before = seen.frame();
            assertThat(seen.items()).hasSizeBetween(2000, 2001); // and the agent
            Perception.Location last =
                    seen.find("ball-1999").orElseThrow().location().orElseThrow();
            assertThat(last.y()).isCloseTo(1 + 0.02 * seen.time(), within(1e-9));
            Outcome ordered =
                    Reve.run(
                            "cluster",
                            "move",
                            "crowd",
                            watching.address(),
                            "--port",
                            Integer.toString(owner.agents()));
            assertThat(ordered.code()).isEqualTo(1);
            assertThat(ordered.err()).contains("only watches");
            Node other = node("--seed", watching.address());
            awaitUp(watching, other);
            owner.server().process().destroyForcibly().onExit().join();
            JsonNode ready = other.server().events().await("ready", _ -> true);
            long resumed = ready.path("frame").asLong();
            assertThat(resumed).isGreaterThanOrEqualTo(before);
            observer.perceiveEvery(6);
            Perception again = agent.perceive(); // it knows no other server than the watching node
            assertThat(again.frame()).isGreaterThan(resumed);
            assertThat(again.find("ada")).isPresent();
            assertThat(next(observer, resumed + 60).frame()).isGreaterThanOrEqualTo(resumed + 60);
        }
    }
}
