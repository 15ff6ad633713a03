// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.port.ClusterPort;
import reve.core.world.ActionRefused;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.URI;
import java.net.http.HttpClient;
import java.net.http.HttpRequest;
import java.net.http.HttpResponse;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.security.MessageDigest;
import java.util.ArrayList;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The paths of the page of the nodes, used through plain HTTP. */
class ClusterPathsTest {
    private static final String TOKEN = "0123456789abcdef0123456789abcdef";

    @TempDir private Path folder;

    private final List<String> orders = new ArrayList<>();
    private AgentServer agents;
    private WebServer page;

    /** Records the orders. Has the node {@code here:1} and no others. */
    private final class Recorder implements ClusterPort {
        @Override
        public Map<String, Object> state() {
            return Map.of("cluster", "lab", "nodes", List.of(Map.of("node", "here:1")));
        }

        @Override
        public Map<String, Object> move(String world, String node) throws ActionRefused {
            if (!node.equals("here:1")) {
                throw new ActionRefused("no-such-node", "the cluster has no node " + node);
            }
            orders.add("move " + world + " to " + node);
            return Map.of("world", world, "to", node);
        }

        @Override
        public Map<String, Object> drain(String node, boolean isDrained) {
            orders.add("drain " + node + " " + isDrained);
            return Map.of("node", node);
        }

        @Override
        public Map<String, Object> add(String text, boolean isAsleep) {
            throw new AssertionError("the page adds no worlds");
        }
    }

    private void start(AgentSecurity security, Optional<ClusterPort> cluster) throws Exception {
        InetSocketAddress any = new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), 0);
        agents =
                AgentServer.start(
                        AgentServerConfig.on(any, security), List.of(), (source, message) -> {});
        page = WebServer.start(any, security, agents, () -> cluster);
    }

    /** Starts a server whose only token has these rights, as they are written in a token file. */
    private void startWithToken(String rights) throws Exception {
        if (page != null) {
            stop();
        }
        String hash =
                HexFormat.of()
                        .formatHex(
                                MessageDigest.getInstance("SHA-256")
                                        .digest(TOKEN.getBytes(StandardCharsets.UTF_8)));
        Path file = folder.resolve("tokens.json");
        Files.deleteIfExists(file);
        Files.createFile(
                file,
                PosixFilePermissions.asFileAttribute(PosixFilePermissions.fromString("rw-------")));
        Files.writeString(
                file,
                "{\"reveTokens\":1,\"tokens\":[{\"name\":\"eve\",\"sha256\":\""
                        + hash
                        + "\","
                        + rights
                        + "}]}");
        start(
                new AgentSecurity(Optional.of(TokenFile.open(file)), Optional.empty()),
                Optional.of(new Recorder()));
    }

    @AfterEach
    void stop() {
        page.close();
        agents.close();
    }

    /**
     * @param headers names and values in turn
     */
    private HttpResponse<String> send(String method, String path, String... headers)
            throws Exception {
        HttpRequest.Builder request =
                HttpRequest.newBuilder(URI.create(page.address() + path))
                        .method(method, HttpRequest.BodyPublishers.noBody());
        if (headers.length > 0) {
            request.headers(headers);
        }
        try (HttpClient http = HttpClient.newHttpClient()) {
            return http.send(request.build(), HttpResponse.BodyHandlers.ofString());
        }
    }

    private String origin() {
        return page.address().substring(0, page.address().length() - 1);
    }

    private static JsonNode json(HttpResponse<String> answer) {
        return new JsonMapper().readTree(answer.body());
    }

    @Test
    void thePageReadsTheClusterAndGivesOrders() throws Exception {
        start(AgentSecurity.NONE, Optional.of(new Recorder()));
        assertThat(send("GET", "nodes").body()).contains("nodes.js");
        HttpResponse<String> state = send("GET", "cluster");
        assertThat(state.statusCode()).isEqualTo(200);
        assertThat(state.headers().firstValue("Content-Type")).contains("application/json");
        assertThat(json(state).at("/nodes/0/node").asString()).isEqualTo("here:1");
        HttpResponse<String> moved =
                send("POST", "cluster/move?world=w%201&node=here:1", "Origin", origin());
        assertThat(moved.statusCode()).isEqualTo(200);
        assertThat(json(moved).path("world").asString()).isEqualTo("w 1");
        send("POST", "cluster/drain?node=here:1&drained=true", "Origin", origin());
        send("POST", "cluster/drain?node=here:1&drained=false", "Origin", origin());
        assertThat(orders)
                .containsExactly("move w 1 to here:1", "drain here:1 true", "drain here:1 false");
    }

    @Test
    void whatCannotBeFollowedIsRefusedWithACode() throws Exception {
        start(AgentSecurity.NONE, Optional.of(new Recorder()));
        HttpResponse<String> refused =
                send("POST", "cluster/move?world=w1&node=there:2", "Origin", origin());
        assertThat(refused.statusCode()).isEqualTo(409);
        assertThat(json(refused).path("code").asString()).isEqualTo("no-such-node");
        assertThat(json(refused).path("reason").asString()).contains("there:2");
        for (String wrong :
                List.of("move?world=w1", "move?node=here:1", "drain?node=here:1&drained=yes")) {
            HttpResponse<String> answer = send("POST", "cluster/" + wrong, "Origin", origin());
            assertThat(answer.statusCode()).as(wrong).isEqualTo(409);
            assertThat(json(answer).path("code").asString()).as(wrong).isEqualTo("bad-message");
        }
        assertThat(send("GET", "cluster/move?world=w1&node=here:1").statusCode()).isEqualTo(405);
        assertThat(send("POST", "cluster", "Origin", origin()).statusCode()).isEqualTo(405);
        assertThat(orders).isEmpty();
    }

    /** The page of another site could send such a request from the operator's browser. */
    @Test
    void ordersOfOtherOriginsAreRefused() throws Exception {
        start(AgentSecurity.NONE, Optional.of(new Recorder()));
        String order = "cluster/drain?node=here:1&drained=true";
        assertThat(send("POST", order).statusCode()).isEqualTo(403);
        assertThat(send("POST", order, "Origin", "http://example.org").statusCode()).isEqualTo(403);
        assertThat(send("POST", order, "Origin", "null").statusCode()).isEqualTo(403);
        assertThat(orders).isEmpty();
    }

    @Test
    void aServerWithoutAClusterSaysSo() throws Exception {
        start(AgentSecurity.NONE, Optional.empty());
        HttpResponse<String> none = send("GET", "cluster");
        assertThat(none.statusCode()).isEqualTo(503);
        assertThat(json(none).path("reason").asString()).contains("belongs to no cluster");
    }

    @Test
    void onlyATokenThatControlsAllWorldsSeesTheCluster() throws Exception {
        String order = "cluster/drain?node=here:1&drained=true";
        String bearer = "Bearer " + TOKEN;
        startWithToken("\"roles\":[\"control\"]");
        HttpResponse<String> none = send("GET", "cluster");
        assertThat(none.statusCode()).isEqualTo(401);
        assertThat(none.body()).doesNotContain("lab", "here:1");
        assertThat(send("GET", "cluster", "Authorization", "Bearer wrong").statusCode())
                .isEqualTo(401);
        assertThat(send("POST", order, "Origin", origin()).statusCode()).isEqualTo(401);
        assertThat(orders).isEmpty();
        assertThat(send("GET", "cluster", "Authorization", bearer).statusCode()).isEqualTo(200);
        assertThat(send("POST", order, "Origin", origin(), "Authorization", bearer).statusCode())
                .isEqualTo(200);
        assertThat(orders).hasSize(1);
        for (String rights :
                List.of(
                        "\"roles\":[\"observer\",\"agent\"]",
                        "\"roles\":[\"control\"],\"worlds\":[\"pond\"]")) {
            startWithToken(rights);
            HttpResponse<String> refused = send("GET", "cluster", "Authorization", bearer);
            assertThat(refused.statusCode()).as(rights).isEqualTo(403);
            assertThat(refused.body()).doesNotContain("lab", "here:1");
            assertThat(
                            send("POST", order, "Origin", origin(), "Authorization", bearer)
                                    .statusCode())
                    .as(rights)
                    .isEqualTo(403);
        }
        startWithToken("\"roles\":[\"control\"],\"laws\":[\"drag\"]");
        assertThat(send("POST", order, "Origin", origin(), "Authorization", bearer).statusCode())
                .as("it may change single laws only")
                .isEqualTo(403);
        assertThat(orders).hasSize(1);
    }
}
