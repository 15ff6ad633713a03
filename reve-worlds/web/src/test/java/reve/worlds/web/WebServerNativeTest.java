// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIOException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.AgentServerConfig;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.TokenFile;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.SqliteStore;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.net.URI;
import java.net.http.HttpClient;
import java.net.http.HttpRequest;
import java.net.http.HttpResponse;
import java.net.http.WebSocket;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.security.MessageDigest;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Scanner;
import java.util.Set;
import java.util.TreeSet;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionStage;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** The page's server, used through plain HTTP and WebSockets. */
class WebServerNativeTest {

    private static final String WORLD =
            """
            reve: 1
            name: pond
            laws: [gravity_field, newton_motion]
            constants: {gravity: [0, -9.81, 0]}
            camera: {eye: [0, 2, 9], target: [0, 1, 0]}
            agents:
              body:
                physical: {shape: box, size: [0.5, 1, 0.5], location: [0, 0.5, 0]}
                sensors: {eyes: {range: 2 m}}
            items:
              - name: ball
                physical: {shape: sphere, radius: 0.5, location: [1, 100, 0], colour: "#336699"}
                physics: {mass: 2 kg, velocity: [0.25, 0, 0]}
              - name: stone
                physical: {shape: box, size: [1, 2, 3], location: [5, 1, 0]}
              - name: anchor
                physical: {location: [0, 3, 0]}
                physics: {mass: 0}
              - {name: rope, kind: spring, physical: {colour: "#336699", width: 5 cm},
                  physics: {end1: anchor, end2: ball, length: 1}}
              - {name: floor, physical: {shape: plane, size: [20, 20]}}
            """;

    @TempDir private Path folder;

    private WorldServer server;
    private WebServer page;
    private Thread world;

    @BeforeEach
    void start() throws Exception {
        start(AgentSecurity.NONE);
    }

    private void start(AgentSecurity security) throws Exception {
        Path file = Files.writeString(folder.resolve("pond.yaml"), WORLD);
        WorldDescription description = WorldFile.load(file);
        var persistence =
                new Persistence(
                        folder,
                        Optional.empty(),
                        Optional.empty(),
                        Optional.empty(),
                        10,
                        SqliteStore.Durability.NORMAL);
        var plan =
                new WorldPlan(
                        description, Long.MAX_VALUE, persistence, new Pictures(folder, List.of()));
        InetSocketAddress any = new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), 0);
        server =
                new WorldServer(
                        List.of(plan),
                        Pacing.REAL_TIME,
                        AgentServerConfig.on(any, security),
                        Optional.empty(),
                        (event, fields) -> {});
        page =
                WebServer.start(
                        any,
                        security,
                        server.agents(),
                        List.of(new PageWorld(server.ports().getFirst(), description.camera())));
        world = Thread.ofPlatform().name("world of the test").start(server::run);
        waitUntilTheWorldRuns();
    }

    /**
     * A world that has not started yet makes no frames, so {@code /health} answers 503 till then.
     */
    private void waitUntilTheWorldRuns() throws InterruptedException {
        long deadline = System.nanoTime() + TimeUnit.SECONDS.toNanos(300);
        while (server.ports().getFirst().loop().thread() == null) {
            assertThat(System.nanoTime()).as("the world runs").isLessThan(deadline);
            TimeUnit.MILLISECONDS.sleep(1);
        }
    }

    @AfterEach
    void stop() throws Exception {
        page.close();
        server.stop();
        world.join();
        server.close();
    }

    private HttpResponse<String> get(String path) throws IOException, InterruptedException {
        try (HttpClient http = HttpClient.newHttpClient()) {
            return http.send(
                    HttpRequest.newBuilder(URI.create(page.address() + path)).build(),
                    HttpResponse.BodyHandlers.ofString());
        }
    }

    @Test
    void thePageAsksNoOtherServer() throws Exception {
        HttpResponse<String> index = get("");
        assertThat(index.statusCode()).isEqualTo(200);
        assertThat(index.headers().firstValue("Content-Security-Policy").orElseThrow())
                .contains("default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'");
        Matcher files =
                Pattern.compile("(?:src|href|from)[= ]*[\"'](?!#)([^\"']+)").matcher(index.body());
        int found = 0;
        while (files.find()) {
            assertThat(get(files.group(1)).statusCode()).as(files.group(1)).isEqualTo(200);
            found++;
        }
        assertThat(found).isGreaterThanOrEqualTo(4);
        for (String script : OwnScripts.NAMES) {
            HttpResponse<String> answer = get(script);
            assertThat(answer.statusCode()).as(script).isEqualTo(200);
            assertThat(answer.body()).doesNotContain("https://", "http://");
            assertThat(answer.headers().firstValue("Content-Type").orElseThrow())
                    .startsWith("text/javascript");
        }
        assertThat(get("three/three.module.js").statusCode()).isEqualTo(200);
        assertThat(get("three/three.core.min.js").statusCode()).isEqualTo(200);
        assertThat(get("uplot/uPlot.js").statusCode()).isEqualTo(200);
    }

    @Test
    void supervisorsReadHealthAndCounters() throws Exception {
        assertThat(get("health").body()).isEqualTo("ok\n");
        long frame = server.ports().getFirst().loop().frame();
        while (server.ports().getFirst().loop().frame() < frame + 10) {
            Thread.sleep(10);
        }
        HttpResponse<String> counters = get("metrics");
        assertThat(counters.headers().firstValue("Content-Type").orElseThrow())
                .startsWith("text/plain; version=0.0.4");
        Matcher frames =
                Pattern.compile("reve_frames_total\\{world=\"pond\"} ([0-9.]+)")
                        .matcher(counters.body());
        assertThat(frames.find()).as(counters.body()).isTrue();
        assertThat(Double.parseDouble(frames.group(1))).isGreaterThanOrEqualTo(frame + 10);
        assertThat(counters.body())
                .contains("reve_phase_seconds_total{phase=\"physics\",world=\"pond\"}")
                .contains("reve_agents 0.0")
                .containsPattern("reve_heap_max_bytes [1-9]")
                .containsPattern("reve_heap_used_bytes [1-9]");
        requireHistogram(counters.body());
        requireDashboard(counters.body());
        server.stop();
        world.join();
        assertThat(get("health").statusCode()).isEqualTo(503);
    }

    /** Each frame is in one bucket, and the buckets are cumulative, as Prometheus expects. */
    private static void requireHistogram(String counters) {
        List<Double> buckets =
                Pattern.compile(
                                "reve_frame_seconds_bucket\\{world=\"pond\",le=\"[^\"]+\"} ([0-9.]+)")
                        .matcher(counters)
                        .results()
                        .map(found -> Double.valueOf(found.group(1)))
                        .toList();
        assertThat(buckets).as(counters).hasSize(17).isSorted();
        Matcher count =
                Pattern.compile("reve_frame_seconds_count\\{world=\"pond\"} ([0-9.]+)")
                        .matcher(counters);
        assertThat(count.find()).isTrue();
        assertThat(Double.valueOf(count.group(1))).isEqualTo(buckets.getLast()).isPositive();
        Matcher sum =
                Pattern.compile("reve_frame_seconds_sum\\{world=\"pond\"} ([0-9.E-]+)")
                        .matcher(counters);
        assertThat(sum.find()).isTrue();
        assertThat(Double.parseDouble(sum.group(1))).isPositive();
    }

    /** Requires that the server has all counters of the dashboard in the documents. */
    private static void requireDashboard(String counters) throws IOException {
        Path file = Path.of(System.getProperty("reve.root"), "docs/grafana-dashboard.json");
        JsonNode dashboard = new JsonMapper().readTree(Files.readString(file));
        Set<String> names = new TreeSet<>();
        for (JsonNode panel : dashboard.get("panels")) {
            for (JsonNode target : panel.get("targets")) {
                Pattern.compile("reve_[a-z_]+")
                        .matcher(target.get("expr").asString())
                        .results()
                        .forEach(found -> names.add(found.group()));
            }
        }
        assertThat(names).hasSizeGreaterThan(10);
        assertThat(names)
                .allSatisfy(
                        name ->
                                assertThat(counters)
                                        .containsPattern("(?m)^" + name + "(\\{[^}]*})? [0-9]"));
    }

    @Test
    void aConnectionWithThousandsOfRequestsWaitsForOthers() throws Exception {
        int requests = 5000;
        URI address = URI.create(page.address());
        String request =
                "GET /health HTTP/1.1\r\nHost: %s\r\n\r\n".formatted(address.getAuthority());
        var answers = new AtomicInteger();
        try (Socket flood = new Socket(address.getHost(), address.getPort())) {
            Thread.ofVirtual()
                    .start(
                            () -> {
                                try (Scanner lines = new Scanner(flood.getInputStream())) {
                                    while (lines.hasNextLine()) {
                                        if (lines.nextLine().startsWith("HTTP/1.1 200")) {
                                            answers.incrementAndGet();
                                        }
                                    }
                                } catch (IOException closed) {
                                    // The test has ended.
                                }
                            });
            byte[] all = request.repeat(requests).getBytes(StandardCharsets.US_ASCII);
            Thread.ofVirtual()
                    .start(
                            () -> {
                                try {
                                    flood.getOutputStream().write(all);
                                } catch (IOException closed) {
                                    // The test has ended.
                                }
                            });
            for (int i = 0; i < 20; i++) {
                assertThat(get("health").statusCode()).isEqualTo(200);
            }
            assertThat(answers.get()).isLessThan(requests);
        }
    }

    @Test
    void aWebSocketWithThousandsOfPingsWaitsForOthers() throws Exception {
        int pings = 3000;
        var pongs = new AtomicInteger();
        var first = new CompletableFuture<String>();
        try (HttpClient http = HttpClient.newHttpClient()) {
            WebSocket socket =
                    http.newWebSocketBuilder()
                            .header("Origin", page.address().replaceAll("/$", ""))
                            .buildAsync(
                                    URI.create(page.address().replace("http", "ws") + "world"),
                                    new WebSocket.Listener() {
                                        @Override
                                        public CompletionStage<?> onPong(
                                                WebSocket from, ByteBuffer payload) {
                                            pongs.incrementAndGet();
                                            first.complete(
                                                    StandardCharsets.US_ASCII
                                                            .decode(payload)
                                                            .toString());
                                            from.request(1);
                                            return null;
                                        }
                                    })
                            .join();
            for (int i = 0; i < pings; i++) {
                socket.sendPing(ByteBuffer.wrap(new byte[] {'a', 'b'})).join();
            }
            assertThat(first.join()).isEqualTo("ab");
            assertThat(get("health").statusCode()).isEqualTo(200);
            assertThat(pongs.get()).isLessThan(pings);
            socket.abort();
        }
    }

    @Test
    void noOtherFileIsServed() throws Exception {
        for (String path :
                List.of(
                        "WebServer.class",
                        "..%2findex.html",
                        "%2e%2e/style.css",
                        "page",
                        "etc/passwd")) {
            assertThat(get(path).statusCode()).as(path).isIn(400, 404);
        }
    }

    @Test
    void pagesOfOtherOriginsOpenNoWebSocket() {
        for (String origin :
                List.of(
                        "http://example.com",
                        "null",
                        page.address().substring(0, page.address().length() - 1) + "1",
                        page.address().replace("http", "https"))) {
            assertThatIOException()
                    .as(origin)
                    .isThrownBy(() -> new PageClient(page.address(), origin).close());
        }
    }

    @Test
    void aWebSocketWithTwoOriginsIsRefused() throws Exception {
        URI address = URI.create(page.address());
        try (var socket = new Socket("127.0.0.1", address.getPort())) {
            socket.getOutputStream()
                    .write(
                            ("GET /world HTTP/1.1\r\nHost: "
                                            + address.getAuthority()
                                            + "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                                            + "Sec-WebSocket-Version: 13\r\n"
                                            + "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
                                            + "Origin: http://"
                                            + address.getAuthority()
                                            + "\r\nOrigin: http://example.com\r\n\r\n")
                                    .getBytes(StandardCharsets.US_ASCII));
            var answer =
                    new String(socket.getInputStream().readNBytes(13), StandardCharsets.US_ASCII);
            assertThat(answer).isEqualTo("HTTP/1.1 403 ");
        }
    }

    @Test
    void otherHostNamesLeadNowhere() throws Exception {
        URI address = URI.create(page.address());
        try (var socket = new Socket("127.0.0.1", address.getPort())) {
            socket.getOutputStream()
                    .write(
                            "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"
                                    .getBytes(StandardCharsets.US_ASCII));
            String answer =
                    new String(socket.getInputStream().readAllBytes(), StandardCharsets.ISO_8859_1);
            assertThat(answer).startsWith("HTTP/1.1 421 ").doesNotContain("<script");
        }
    }

    @Test
    void anObserverSeesWhatTheProtocolReports() throws Exception {
        try (var client = new PageClient(page.address())) {
            JsonNode welcome = client.join("eye", "observer");
            assertThat(welcome.get("world").asString()).isEqualTo("pond");
            client.watch(1);
            PageClient.Frame first = client.frame();
            assertThat(first.structure().at("/camera/eye/2").doubleValue()).isEqualTo(9);
            var items = new java.util.TreeMap<String, JsonNode>();
            first.structure()
                    .get("items")
                    .forEach(item -> items.put(item.get("name").asString(), item));
            assertThat(items).containsKeys("ball", "stone", "rope", "floor", "world");
            int ball = items.get("ball").get("slot").asInt();
            int stone = items.get("stone").get("slot").asInt();
            assertThat(items.get("ball").get("shape").asInt()).isEqualTo(1);
            assertThat(items.get("rope").get("refers").get(1).asInt()).isEqualTo(ball);
            assertThat(items.get("rope").get("colour").longValue()).isEqualTo(0xff996633L);
            assertThat(items.get("rope").get("width").doubleValue()).isEqualTo(0.05);
            assertThat(column(first, SceneColumns.SIZE).get(stone)).containsExactly(1, 2, 3);
            int colour = Float.floatToRawIntBits(column(first, SceneColumns.COLOUR).get(ball)[0]);
            assertThat(colour).isEqualTo(0xff996633);
            // Free fall by semi-implicit Euler: y(n) = 100 - g dt² n (n + 1) / 2.
            client.watch(1);
            PageClient.Frame later = client.frame();
            assertThat(later.frame()).isGreaterThan(first.frame());
            assertThat(column(later, SceneColumns.POSITION)).containsOnlyKeys(ball);
            float[] place = column(later, SceneColumns.POSITION).get(ball);
            double dt = later.time() / later.frame();
            assertThat(place[0]).isCloseTo((float) (1 + 0.25 * later.time()), within(1e-4f));
            assertThat((double) place[1])
                    .isCloseTo(100 - 9.81 * later.time() * later.time() / 2, within(0.2));
            assertThat(column(later, SceneColumns.VELOCITY).get(ball)[1])
                    .isCloseTo((float) (-9.81 * later.time()), within(1e-2f));
            assertThat(dt).isCloseTo(1 / 60.0, within(1e-9));
            client.say("{\"t\":\"inspect\",\"id\":5,\"item\":\"rope\"}");
            JsonNode rope = client.answer(5).at("/content/physical");
            assertThat(rope)
                    .extracting(property -> property.get("name").asString())
                    .containsExactly("colour", "width");
            assertThat(rope.at("/0/value").asString()).isEqualTo("#336699ff");
            assertThat(rope.at("/1/value").doubleValue()).isEqualTo(0.05);
        }
    }

    private static Map<Integer, float[]> column(PageClient.Frame frame, SceneColumns column) {
        return frame.columns().getOrDefault(column.ordinal(), Map.of());
    }

    @Test
    void oneRequestGetsOneFrameAndAHangingPageHoldsNothingUp() throws Exception {
        try (var client = new PageClient(page.address())) {
            client.join("slow", "control");
            client.watch(0);
            long first = client.frame().frame();
            client.hang();
            client.watch(0);
            client.watch(0);
            long before = server.ports().getFirst().loop().frame();
            while (server.ports().getFirst().loop().frame() < before + 60) {
                Thread.sleep(20);
            }
            client.readAgain();
            long second = client.frame().frame();
            assertThat(second).isGreaterThan(first);
            while (client.frames.poll(300, TimeUnit.MILLISECONDS) != null) {}
            client.watch(0);
            assertThat(client.frame().frame()).isGreaterThan(before + 50);
        }
    }

    @Test
    void aPageThatReadsNothingDoesNotOutliveItsSession() throws Exception {
        try (var client = new PageClient(page.address())) {
            client.join("slow", "control");
            client.hang();
            long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(60);
            for (int id = 1; page.connections() > 0; id++) {
                assertThat(System.nanoTime()).as("the page is still connected").isLessThan(end);
                try {
                    client.say("{\"t\":\"laws\",\"id\":" + id + "}"); // also ends the silence
                } catch (java.util.concurrent.CompletionException disconnected) {
                    // The next look at the connections shows it.
                }
            }
            assertThat(server.agents().stats().cut()).isEqualTo(1);
        }
    }

    @Test
    void anAgentReceivesNoSceneBesideItsPerceptions() throws Exception {
        try (var client = new PageClient(page.address())) {
            client.join("ada", "agent");
            client.watch(3);
            client.say("{\"t\":\"perceive\",\"id\":7}");
            JsonNode perception = client.answer(7);
            assertThat(perception.get("items"))
                    .extracting(item -> item.get("name").asString())
                    .contains("ada")
                    .doesNotContain("stone", "ball");
            client.say("{\"t\":\"inspect\",\"id\":8,\"item\":\"ball\"}");
            assertThat(client.answer(8).get("code").asString()).isEqualTo("not-permitted");
            assertThat(client.frames.poll(500, TimeUnit.MILLISECONDS)).isNull();
        }
    }

    @Test
    void nothingIsSentBeforeAHello() throws Exception {
        try (var client = new PageClient(page.address())) {
            client.watch(3);
            assertThat(client.frames.poll(500, TimeUnit.MILLISECONDS)).isNull();
            assertThat(client.lines).isEmpty();
        }
    }

    /** Starts the server with one token for an observer with the name eve. */
    private void startWithToken(String token, String rights) throws Exception {
        stop();
        Path file = folder.resolve("tokens.json");
        Files.deleteIfExists(file);
        Files.createFile(
                file,
                PosixFilePermissions.asFileAttribute(PosixFilePermissions.fromString("rw-------")));
        Files.writeString(
                file,
                "{\"reveTokens\":1,\"tokens\":[{\"name\":\"eve\",\"sha256\":\""
                        + HexFormat.of()
                                .formatHex(
                                        MessageDigest.getInstance("SHA-256")
                                                .digest(token.getBytes(StandardCharsets.US_ASCII)))
                        + "\",\"roles\":[\"observer\"]"
                        + rights
                        + "}]}");
        start(new AgentSecurity(Optional.of(TokenFile.open(file)), Optional.empty()));
    }

    private String counters(String token) throws IOException, InterruptedException {
        try (HttpClient http = HttpClient.newHttpClient()) {
            return http.send(
                            HttpRequest.newBuilder(URI.create(page.address() + "metrics"))
                                    .setHeader("Authorization", "Bearer " + token)
                                    .build(),
                            HttpResponse.BodyHandlers.ofString())
                    .body();
        }
    }

    @Test
    void aTokenForSomeWorldsReadsTheCountersOfTheseWorldsOnly() throws Exception {
        String token = "0123456789abcdef0123456789abcdef";
        startWithToken(token, ",\"worlds\":[\"pond\"]");
        assertThat(counters(token))
                .contains("reve_frames_total{world=\"pond\"}")
                .doesNotContain("reve_agents", "reve_joined", "reve_heap");
        startWithToken(token, ",\"worlds\":[\"sea\"]");
        assertThat(counters(token)).doesNotContain("pond", "reve_agents");
        startWithToken(token, "");
        assertThat(counters(token)).contains("world=\"pond\"", "reve_agents");
    }

    @Test
    void aPageReadsLinesOfJsonOnly() throws Exception {
        try (var client = new PageClient(page.address())) {
            client.say(
                    "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\",\"role\":\"observer\","
                            + "\"encoding\":\"msgpack\"}");
            assertThat(client.await("bye").get("code").asString())
                    .isEqualTo("encoding-unsupported");
        }
    }

    @Test
    void aResumedSessionShowsTheSceneAtTheNewPageOnly() throws Exception {
        try (var first = new PageClient(page.address());
                var second = new PageClient(page.address())) {
            first.say(
                    "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\",\"role\":\"observer\","
                            + "\"graceSeconds\":60}");
            String secret = first.await("welcome").at("/session/token").asString();
            first.watch(0);
            first.frame();
            second.say(
                    "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\",\"role\":\"observer\","
                            + "\"resume\":{\"session\":\""
                            + secret
                            + "\",\"frame\":0}}");
            assertThat(second.await("welcome").get("resumed").booleanValue()).isTrue();
            second.watch(0);
            assertThat(second.frame().structure().get("items")).isNotEmpty();
            assertThat(first.await("bye").get("code").asString()).isEqualTo("resumed");
        }
    }

    @Test
    void aWrongTokenOpensNothing() throws Exception {
        String token = "0123456789abcdef0123456789abcdef";
        startWithToken(token, "");
        try (var client = new PageClient(page.address())) {
            client.say(
                    "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\",\"role\":\"control\",\"token\":\"x\"}");
            client.watch(0);
            assertThat(client.await("bye").get("code").asString()).isEqualTo("bad-token");
            assertThat(client.frames.poll(300, TimeUnit.MILLISECONDS)).isNull();
        }
        try (var client = new PageClient(page.address())) {
            client.say("{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\",\"role\":\"control\"}");
            assertThat(client.await("bye").get("code").asString()).isEqualTo("bad-token");
        }
        String hello =
                "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eve\",\"token\":\""
                        + token
                        + "\",\"role\":";
        try (var client = new PageClient(page.address())) {
            client.say(hello + "\"control\"}");
            assertThat(client.await("bye").get("code").asString()).isEqualTo("not-permitted");
        }
        try (var client = new PageClient(page.address())) {
            client.say(hello + "\"observer\"}");
            client.await("welcome");
            client.watch(0);
            assertThat(client.frame().structure().get("items")).isNotEmpty();
            client.say("{\"t\":\"pause\",\"id\":1}");
            assertThat(client.answer(1).get("code").asString()).isEqualTo("not-permitted");
        }
        assertThat(get("health").statusCode()).isEqualTo(200);
        assertThat(get("metrics").statusCode()).isEqualTo(401);
        try (HttpClient http = HttpClient.newHttpClient()) {
            HttpRequest.Builder request =
                    HttpRequest.newBuilder(URI.create(page.address() + "metrics"));
            assertThat(
                            http.send(
                                            request.setHeader("Authorization", "Bearer wrong")
                                                    .build(),
                                            HttpResponse.BodyHandlers.ofString())
                                    .statusCode())
                    .isEqualTo(401);
            assertThat(
                            http.send(
                                            request.setHeader("Authorization", "Bearer " + token)
                                                    .build(),
                                            HttpResponse.BodyHandlers.ofString())
                                    .body())
                    .contains("reve_frames_total");
        }
    }

    @Test
    void reportsTellLawsItemsAndTheLedger() throws Exception {
        try (var client = new PageClient(page.address())) {
            client.join("room", "control");
            client.say("{\"t\":\"laws\",\"id\":1}");
            JsonNode laws = client.answer(1).get("content");
            assertThat(laws.at("/loaded/0/library").asString()).isEqualTo("gravity_field");
            JsonNode use = laws.at("/loaded/0/laws/0/uses");
            assertThat(use)
                    .anySatisfy(
                            each -> {
                                assertThat(each.get("name").asString()).isEqualTo("gravity");
                                assertThat(each.get("unit").asString()).isEqualTo("m/s^2");
                                assertThat(each.get("access").get(0).asString()).isEqualTo("read");
                            });
            assertThat(laws.get("available")).extracting(JsonNode::asString).contains("drag");
            client.say("{\"t\":\"inspect\",\"id\":2,\"item\":\"ball\"}");
            JsonNode ball = client.answer(2).get("content");
            assertThat(ball.get("physics"))
                    .anySatisfy(
                            each -> {
                                assertThat(each.get("name").asString()).isEqualTo("mass");
                                assertThat(each.get("value").doubleValue()).isEqualTo(2);
                                assertThat(each.get("unit").asString()).isEqualTo("kg");
                            });
            assertThat(ball.at("/physical/2/value").asString()).isEqualTo("sphere");
            client.say("{\"t\":\"ledger\",\"id\":3,\"open\":true}");
            assertThat(client.answer(3).at("/content/open").booleanValue()).isTrue();
            long from = server.ports().getFirst().loop().frame();
            while (server.ports().getFirst().loop().frame() < from + 10) {
                Thread.sleep(10);
            }
            client.say("{\"t\":\"ledger\",\"id\":4}");
            JsonNode line = client.answer(4).at("/content/lines/0");
            assertThat(line.get("name").asString()).isEqualTo("gravity_field");
            assertThat(line.get("momentum").get(1).doubleValue()).isNegative();
            client.say("{\"t\":\"state\",\"id\":5}");
            JsonNode state = client.answer(5).get("content");
            assertThat(state.get("clients").get(0).get("name").asString()).isEqualTo("room");
            assertThat(state.at("/phaseSeconds/physics").doubleValue()).isPositive();
            client.say("{\"t\":\"speed\",\"id\":6,\"factor\":0.5}");
            assertThat(client.answer(6).get("accepted").booleanValue()).isTrue();
            client.say("{\"t\":\"inspect\",\"id\":9,\"item\":\"nothing\"}");
            assertThat(client.answer(9).get("code").asString()).isEqualTo("no-such-item");
        }
    }
}
