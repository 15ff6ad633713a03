// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.Seed;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.ServerTls;
import reve.core.world.ItemDefinition;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Duration;
import java.time.Instant;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.atomic.AtomicReference;

import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLEngine;
import javax.net.ssl.SSLException;
import javax.net.ssl.SSLSocket;

/** Encrypted connections. */
class TlsTest {
    /** Number of lines that are cut at random places. A long run uses 200. */
    private static final int LINES = Integer.getInteger("reve.test.lines", 60);

    private static final int HANDSHAKES = 40;

    private static final Duration NEVER = Duration.ofMinutes(5);
    private static final String HELLO = "{'t':'hello','protocol':1,'name':'ada'}";

    @TempDir private static Path folder;
    private static Certificate server;
    private static SSLContext trusting;

    private AgentRoom room;

    @BeforeAll
    static void makeCertificates() throws Exception {
        server = Certificate.make(folder, "server");
        trusting = server.trusting();
    }

    @AfterAll
    static void forget() {
        trusting = null;
    }

    @BeforeEach
    void openARoom() throws IOException {
        room = new AgentRoom(with(AgentRoom.CONFIG, server));
    }

    @AfterEach
    void close() {
        room.close();
    }

    private static AgentServerConfig with(AgentServerConfig c, Certificate certificate)
            throws IOException {
        return new AgentServerConfig(
                c.address(),
                c.limits(),
                c.timeouts(),
                c.audit(),
                new AgentSecurity(Optional.empty(), Optional.of(certificate.tls())));
    }

    private static SSLSocket secure(SSLContext context, InetSocketAddress address)
            throws IOException {
        return (SSLSocket)
                context.getSocketFactory().createSocket(address.getAddress(), address.getPort());
    }

    private TestClient connect() throws IOException {
        return new TestClient(secure(trusting, room.server.address()));
    }

    private TestClient join(AgentRoom in) throws IOException {
        TestClient ada = new TestClient(secure(trusting, in.server.address())).say(HELLO).sync();
        in.step();
        ada.expect("welcome");
        ada.expect("event");
        return ada;
    }

    @Test
    void aSessionOverTlsIsAsAnyOther() throws IOException {
        try (TestClient ada = join(room)) {
            assertThat(((SSLSocket) ada.socket).getSession().getProtocol()).isEqualTo("TLSv1.3");
            ada.say("{'t':'act','id':1,'item':'duck','action':'wind-up'}").sync();
            room.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
            ada.skipTo("event");
            ada.say("{'t':'bye'}").expectBye("goodbye");
        }
        room.stepUntil("it is gone", () -> room.server.stats().open() == 0);
    }

    /** A change of keys takes as much time of the event loop as many messages. */
    @Test
    void aClientThatChangesItsKeysOverAndOverIsDisconnected() throws Exception {
        try (TestClient ada = join(room)) {
            SSLSocket socket = (SSLSocket) ada.socket;
            for (int i = 0; i < 20; i++) {
                socket.startHandshake(); // in TLS 1.3: changes the keys
            }
            ada.say("{'t':'ping','id':1}").expect("pong");
            assertThatThrownBy(
                            () -> {
                                for (int i = 0; i < 10_000; i++) {
                                    socket.startHandshake();
                                }
                            })
                    .isInstanceOf(IOException.class);
            room.stepUntil("it is gone", () -> room.server.stats().open() == 0);
        }
    }

    /**
     * Handshakes of many clients are computed by a few platform threads. A thread for each of them
     * stopped the world for seconds.
     */
    @Test
    void aFloodOfHandshakesTakesFewThreads() throws Exception {
        SSLEngine engine = trusting.createSSLEngine("localhost", 1);
        engine.setUseClientMode(true);
        ByteBuffer clientHello = ByteBuffer.allocate(engine.getSession().getPacketBufferSize());
        engine.wrap(ByteBuffer.allocate(0), clientHello);
        byte[] greeting = Arrays.copyOf(clientHello.array(), clientHello.position());
        List<Socket> flood = new ArrayList<>();
        try {
            for (int i = 0; i < HANDSHAKES; i++) {
                Socket socket = new Socket();
                flood.add(socket);
                socket.connect(room.server.address());
                socket.getOutputStream().write(greeting);
            }
            for (Socket socket : flood) { // the server answers each of them
                assertThat(socket.getInputStream().read()).isEqualTo(22);
            }
            int most = Math.max(1, Runtime.getRuntime().availableProcessors() / 2);
            // The threads of a server that an earlier test has closed may need a moment to end.
            room.stepUntil(
                    "1 to " + most + " threads compute",
                    () -> handshakeThreads() >= 1 && handshakeThreads() <= most);
            join(room).close();
        } finally {
            for (Socket socket : flood) {
                socket.close();
            }
        }
    }

    /** Returns the number of platform threads that compute handshakes. */
    private static long handshakeThreads() {
        return Thread.getAllStackTraces().keySet().stream()
                .filter(thread -> thread.getName().equals("tls"))
                .count();
    }

    @Test
    void whatIsCutAnywhereArrivesWhole() throws IOException {
        long seed = Seed.of("the cuts");
        Random random = new Random(seed);
        try (TestClient ada = join(room)) {
            for (int i = 0; i < LINES; i++) {
                byte[] line =
                        ("{\"t\":\"ping\",\"id\":"
                                        + i
                                        + ",\"padding\":\""
                                        + "x".repeat(random.nextInt(40_000))
                                        + "\"}\n")
                                .getBytes(StandardCharsets.US_ASCII);
                for (int at = 0; at < line.length; ) {
                    int next = Math.min(line.length, at + 1 + random.nextInt(20_000));
                    ada.send(Arrays.copyOfRange(line, at, next));
                    at = next;
                }
                assertThat(ada.expect("pong").get("id").intValue()).isEqualTo(i);
            }
        }
    }

    @Test
    void perceptionsLongerThanASocketsBufferArriveWhole() throws IOException {
        for (int i = 0; i < 3000; i++) {
            room.world.add(
                    ItemDefinition.named("stone " + i).symbol("note", "x".repeat(500)).build());
        }
        try (TestClient ada = join(room)) {
            for (int i = 0; i < 3; i++) {
                ada.say("{'t':'perceive','id':" + i + "}").sync();
                room.step();
                JsonNode perception = ada.expect("perception");
                assertThat(perception.get("items").size()).isEqualTo(3002);
            }
        }
    }

    @Test
    void whoDoesNotTrustTheServerGoesAndNobodyElseNotices() throws Exception {
        SSLContext another = Certificate.make(folder, "another").trusting();
        try (TestClient ada = join(room)) {
            try (SSLSocket mistrustful = secure(another, room.server.address())) {
                assertThatThrownBy(mistrustful::startHandshake).isInstanceOf(SSLException.class);
            }
            room.stepUntil("it is gone", () -> room.server.stats().open() == 1);
            assertThat(room.server.stats().cut()).isEqualTo(1);
            ada.sync();
        }
    }

    @Test
    void plainTextIsToldThatTlsIsSpokenHere() throws IOException {
        try (TestClient plain = room.connect()) {
            plain.say(HELLO).expectBye("tls-expected");
        }
    }

    @Test
    void tlsIsToldAtOnceThatNoneIsSpokenHere() throws IOException {
        AgentServerConfig config = AgentRoom.config(NEVER, NEVER, NEVER, NEVER);
        try (AgentRoom open = new AgentRoom(config);
                SSLSocket socket = secure(trusting, open.server.address())) {
            assertThatThrownBy(socket::startHandshake).isInstanceOf(SSLException.class);
            open.stepUntil("it is gone", () -> open.server.stats().open() == 0);
        }
    }

    @Test
    void olderVersionsAreNotSpoken() throws IOException {
        try (SSLSocket old = secure(trusting, room.server.address())) {
            old.setEnabledProtocols(new String[] {"TLSv1.2"});
            assertThatThrownBy(old::startHandshake).isInstanceOf(SSLException.class);
        }
    }

    @Test
    void whoDoesNotFinishTheHandshakeIsCutAndKeepsNobodyWaiting() throws Exception {
        ShortLimit.run(
                soon -> {
                    AgentServerConfig config =
                            with(AgentRoom.config(soon, NEVER, NEVER, NEVER), server);
                    try (AgentRoom brief = new AgentRoom(config)) {
                        List<Socket> silent = new ArrayList<>();
                        for (int i = 0; i < 50; i++) {
                            Socket socket =
                                    new Socket(
                                            brief.server.address().getAddress(),
                                            brief.server.address().getPort());
                            socket.getOutputStream().write(new byte[] {0x16, 3, 1, 2}, 0, i % 5);
                            silent.add(socket);
                        }
                        brief.stepUntil("all are cut", () -> brief.server.stats().cut() == 50);
                        brief.stepUntil("all are gone", () -> brief.server.stats().open() == 0);
                        for (Socket socket : silent) {
                            assertThat(socket.getInputStream().read()).isEqualTo(-1);
                            socket.close();
                        }
                    }
                });
    }

    @Test
    void aRecordThatIsNeverFinishedDoesNotKeepAConnectionOpen() throws Exception {
        ShortLimit.run(
                soon -> {
                    AgentServerConfig config =
                            with(AgentRoom.config(NEVER, soon, soon, NEVER), server);
                    try (AgentRoom brief = new AgentRoom(config);
                            Socket raw =
                                    new Socket(
                                            brief.server.address().getAddress(),
                                            brief.server.address().getPort());
                            TestClient ada =
                                    new TestClient(
                                            trusting.getSocketFactory()
                                                    .createSocket(
                                                            raw,
                                                            "localhost",
                                                            raw.getPort(),
                                                            true))) {
                        ada.say(HELLO).sync();
                        raw.getOutputStream().write(new byte[] {0x17, 3, 3, 0x40, 0, 1, 2, 3});
                        brief.step();
                        ada.skipTo("ping");
                        ada.skipToBye("idle");
                    }
                });
    }

    @Test
    void whoNeverReadsIsCutByTheWriteDeadline() throws Exception {
        ShortLimit.run(
                soon -> {
                    AgentServerConfig config =
                            with(AgentRoom.config(NEVER, NEVER, NEVER, soon), server);
                    try (AgentRoom brief = new AgentRoom(config)) {
                        for (int i = 0; i < 3000; i++) {
                            brief.world.add(
                                    ItemDefinition.named("stone " + i)
                                            .symbol("note", "x".repeat(200))
                                            .build());
                        }
                        try (TestClient blind = join(brief)) {
                            blind.say("{'t':'perceive','every':1}");
                            brief.stepUntil("it is cut", () -> brief.server.stats().cut() == 1);
                            brief.stepUntil("it is gone", () -> brief.server.stats().open() == 0);
                        }
                    }
                });
    }

    @Test
    void noiseInPlaceOfRecordsEndsTheConnection() throws IOException {
        long seed = Seed.of("the noise");
        Random random = new Random(seed);
        for (int i = 0; i < 100; i++) {
            byte[] noise = new byte[1 + random.nextInt(2000)];
            random.nextBytes(noise);
            noise[0] = 0x16;
            try (Socket socket =
                    new Socket(
                            room.server.address().getAddress(), room.server.address().getPort())) {
                socket.getOutputStream().write(noise);
                socket.shutdownOutput();
                socket.getInputStream().readAllBytes();
            } catch (IOException e) {
                // The connection was reset, because the server closed it first.
            }
        }
        room.stepUntil("all are gone", () -> room.server.stats().open() == 0);
        join(room).close();
    }

    @ParameterizedTest
    @ValueSource(strings = {"rw-r-----", "rw--w----", "rw----r--", "rw----r-x"})
    void aKeyThatOthersReadOrWriteIsRefused(String mode) throws Exception {
        Path key =
                Files.copy(
                        server.key(),
                        folder.resolve("open.key"),
                        StandardCopyOption.REPLACE_EXISTING);
        Files.setPosixFilePermissions(key, PosixFilePermissions.fromString(mode));
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), key))
                .hasMessage(
                        key
                                + " is open to others (mode "
                                + mode
                                + "); run `chmod 600 "
                                + key
                                + "`");
        Files.setPosixFilePermissions(key, PosixFilePermissions.fromString("r--------"));
        assertThat(ServerTls.of(server.certificate(), key)).isNotNull();
    }

    /** Repeats a test if this machine was too busy to read a file within half a second. */
    private static void whileFilesAnswer(Callable test) throws Exception {
        for (int attempt = 1; attempt < 5; attempt++) {
            try {
                test.call();
                return;
            } catch (AssertionError failed) {
                if (!failed.getMessage().contains("gives no data for more than")) {
                    throw failed;
                }
            }
        }
        test.call();
    }

    private interface Callable {
        void call() throws Exception;
    }

    /** The files are replaced one right after the other. */
    private static void replace(Certificate files, Certificate by) throws IOException {
        Path certificate = copy(by.certificate());
        Path key = copy(by.key());
        Files.move(certificate, files.certificate(), StandardCopyOption.REPLACE_EXISTING);
        Files.move(key, files.key(), StandardCopyOption.REPLACE_EXISTING);
    }

    private static Path copy(Path file) throws IOException {
        return Files.copy(
                file,
                file.resolveSibling(file.getFileName() + ".copy"),
                StandardCopyOption.COPY_ATTRIBUTES);
    }

    @Test
    void aNewCertificateIsForNewConnectionsAndTheOthersGoOn() throws Exception {
        whileFilesAnswer(
                () -> {
                    Certificate files = Certificate.make(folder, "files");
                    Certificate next = Certificate.make(folder, "next");
                    SSLContext trustingNext = next.trusting();
                    try (AgentRoom own = new AgentRoom(with(AgentRoom.CONFIG, files));
                            TestClient before =
                                    new TestClient(
                                            secure(files.trusting(), own.server.address()))) {
                        before.say("{'t':'hello','protocol':1,'name':'bob'}").sync();
                        replace(files, next);
                        own.stepUntil("it is used", () -> isTrusted(trustingNext, own));
                        before.sync();
                        assertThat(own.problems).isEmpty();

                        Files.writeString(files.certificate(), "nothing");
                        own.stepUntil("it is reported", () -> !own.problems.isEmpty());
                        assertThat(isTrusted(trustingNext, own))
                                .as("the one before is used")
                                .isTrue();
                        replace(files, next);
                        own.stepUntil("it is over", () -> own.problems.size() > 1);
                        assertThat(own.problems).hasSize(2);
                        assertThat(own.problems.poll())
                                .startsWith(
                                        "tls: connections still use the "
                                                + "certificate read before: "
                                                + files.certificate());
                        assertThat(own.problems.poll())
                                .contains(
                                        "new connections use the certificate of "
                                                + files.certificate());
                    }
                });
    }

    private static boolean isTrusted(SSLContext context, AgentRoom in) {
        try (SSLSocket socket = secure(context, in.server.address())) {
            socket.startHandshake();
            return true;
        } catch (IOException e) {
            return false;
        }
    }

    @Test
    void aPairThatIsReplacedOneFileAfterTheOtherIsNoProblem() throws Exception {
        whileFilesAnswer(
                () -> {
                    Certificate files = Certificate.make(folder, "slow");
                    Certificate next = Certificate.make(folder, "later");
                    ServerTls tls = files.tls();
                    Files.copy(
                            next.certificate(),
                            files.certificate(),
                            StandardCopyOption.REPLACE_EXISTING);
                    tls.refresh();
                    assertThat(tls.problem()).isEmpty();
                    replace(files, next);
                    tls.refresh();
                    tls.refresh();
                    assertThat(tls.problem()).isEmpty();
                    Files.setPosixFilePermissions(
                            files.key(), PosixFilePermissions.fromString("rw-r--r--"));
                    tls.refresh();
                    tls.refresh();
                    assertThat(tls.problem())
                            .get()
                            .asString()
                            .contains("is open to others", "chmod 600");
                    Files.delete(files.key());
                    tls.refresh();
                    tls.refresh();
                    assertThat(tls.problem())
                            .get()
                            .asString()
                            .contains("there is no file " + files.key());
                });
    }

    @Test
    void aCertificateThatExpiresWhileTheServerRunsIsReported() throws Exception {
        Instant start = Instant.now();
        AtomicReference<Instant> now = new AtomicReference<>(start);
        ServerTls tls = ServerTls.of(server.certificate(), server.key(), now::get);
        assertThat(tls.problem()).isEmpty();
        now.set(start.plus(Duration.ofDays(10_000)));
        assertThat(tls.problem())
                .get()
                .asString()
                .contains(server.certificate() + " has expired", "replace it and its key");
    }

    @Test
    void filesThatDoNotFitAreNamed() throws Exception {
        Certificate other = Certificate.make(folder, "other");
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), other.key()))
                .hasMessageContaining("other.key is not the key of the certificate in")
                .hasMessageContaining("server.crt");
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), server.certificate()))
                .hasMessageContaining("server.crt")
                .hasMessageContaining("chmod 600");
        Path nothing = Files.writeString(folder.resolve("nothing.pem"), "nothing");
        assertThatThrownBy(() -> ServerTls.of(nothing, server.key()))
                .hasMessageContaining("nothing.pem");
        Files.setPosixFilePermissions(nothing, PosixFilePermissions.fromString("rw-------"));
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), nothing))
                .hasMessageContaining("nothing.pem")
                .hasMessageContaining("openssl pkcs8");
        Files.writeString(nothing, Files.readString(server.key()).substring(0, 100));
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), nothing))
                .hasMessageContaining("nothing.pem is incomplete or damaged: found `BEGIN PRIVATE");
        Path missing = folder.resolve("missing.pem");
        assertThatThrownBy(() -> ServerTls.of(missing, server.key()))
                .hasMessage("there is no file " + missing + ", expected one in PEM");
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), folder))
                .hasMessage("there is no file " + folder + ", expected one in PEM");
        Certificate rsa = Certificate.make(folder, "rsa", "rsa:2048");
        assertThat(rsa.tls()).isNotNull();
        assertThatThrownBy(() -> ServerTls.of(server.certificate(), rsa.key()))
                .hasMessageContaining("certificate's kind, EC;");
    }

    /** The parser would need minutes for such a file. */
    @Test
    void filesOfMegabytesAreRefusedBeforeTheyAreRead(@TempDir Path folder) throws Exception {
        Path large = Files.write(folder.resolve("large.pem"), new byte[1 << 20]);
        assertThatThrownBy(() -> ServerTls.of(large, large))
                .isInstanceOf(IOException.class)
                .hasMessageContaining(large + " has 1048576 bytes, expected a file in PEM")
                .hasMessageContaining("at most 65536");
    }
}
