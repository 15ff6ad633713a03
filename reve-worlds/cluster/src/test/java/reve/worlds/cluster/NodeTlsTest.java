// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIOException;

import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLEngine;
import javax.net.ssl.SSLEngineResult.HandshakeStatus;
import javax.net.ssl.SSLException;
import javax.net.ssl.SSLSession;

/** Handshakes of two nodes in memory, with certificates that OpenSSL has made. */
class NodeTlsTest {
    private static final String HOST = "127.0.0.1";

    @TempDir private static Path folder;

    @BeforeAll
    static void certify() throws Exception {
        for (String authority : List.of("ca", "foreign")) {
            openssl(
                    "req -x509 -nodes -newkey ec -pkeyopt ec_paramgen_curve:P-256 -days 2 -subj /CN="
                            + authority
                            + " -keyout "
                            + authority
                            + ".key -out "
                            + authority
                            + ".crt");
        }
        certify("node", "ca", "IP:127.0.0.1");
        certify("other", "ca", "DNS:other.example");
        certify("stranger", "foreign", "IP:127.0.0.1");
    }

    private static void certify(String name, String authority, String host) throws Exception {
        openssl(
                "req -x509 -nodes -newkey ec -pkeyopt ec_paramgen_curve:P-256 -days 2 -subj /CN="
                        + name
                        + " -addext subjectAltName="
                        + host
                        + " -addext basicConstraints=critical,CA:FALSE -CA "
                        + authority
                        + ".crt -CAkey "
                        + authority
                        + ".key -keyout "
                        + name
                        + ".key -out "
                        + name
                        + ".crt");
    }

    private static void openssl(String arguments) throws Exception {
        List<String> command = new ArrayList<>(List.of("openssl"));
        command.addAll(List.of(arguments.split(" ")));
        Process process =
                new ProcessBuilder(command)
                        .directory(folder.toFile())
                        .redirectErrorStream(true)
                        .start();
        String output = new String(process.getInputStream().readAllBytes());
        assertThat(process.waitFor()).as(output).isZero();
    }

    private static Path file(String name) {
        return folder.resolve(name);
    }

    private static NodeTls node(String name, String authority) throws IOException {
        return new NodeTls(
                new NodeTls.Files(
                                file(name + ".crt"), file(name + ".key"), file(authority + ".crt"))
                        .context());
    }

    @Test
    void nodesOfOneAuthorityTalk() throws Exception {
        SSLSession session =
                handshake(
                        node("other", "ca").createClientSSLEngine(HOST, 1),
                        node("node", "ca").createServerSSLEngine(HOST, 1));
        assertThat(session.getProtocol()).isEqualTo("TLSv1.3");
        assertThat(session.getPeerPrincipal().getName()).isEqualTo("CN=other");
    }

    @Test
    void aStrangerIsRefusedByBothSides() throws Exception {
        assertRefused(
                node("stranger", "ca").createClientSSLEngine(HOST, 1),
                node("node", "ca").createServerSSLEngine(HOST, 1));
        assertRefused(
                node("node", "ca").createClientSSLEngine(HOST, 1),
                node("stranger", "ca").createServerSSLEngine(HOST, 1));
    }

    @Test
    void aClientWithoutACertificateIsRefused() throws Exception {
        SSLContext trusting = ClientWithoutCertificate.trusting(file("ca.crt"));
        SSLEngine client = trusting.createSSLEngine(HOST, 1);
        client.setUseClientMode(true);
        assertRefused(client, node("node", "ca").createServerSSLEngine(HOST, 1));
    }

    @Test
    void aNodeAtAnotherHostThanItsCertificateSaysIsRefused() throws Exception {
        assertRefused(
                node("node", "ca").createClientSSLEngine(HOST, 1),
                node("other", "ca").createServerSSLEngine(HOST, 1));
    }

    @Test
    void filesThatDoNotFitAreRefused() throws Exception {
        assertThatIOException()
                .isThrownBy(() -> node("nobody", "ca"))
                .withMessageContaining("nobody.crt");
        Path empty = Files.createFile(file("empty.crt"));
        assertThatIOException()
                .isThrownBy(() -> node("node", "empty"))
                .withMessageContaining(empty + " is empty");
        assertThatIOException()
                .isThrownBy(
                        () ->
                                new NodeTls.Files(
                                                file("node.crt"), file("other.key"), file("ca.crt"))
                                        .context())
                .withMessageContaining("other.key is not the key of the certificate in");
    }

    private static void assertRefused(SSLEngine client, SSLEngine server) {
        assertThatExceptionOfType(SSLException.class).isThrownBy(() -> handshake(client, server));
    }

    /** Returns the session of the server. */
    private static SSLSession handshake(SSLEngine client, SSLEngine server) throws SSLException {
        ByteBuffer toServer = ByteBuffer.allocate(65_536);
        ByteBuffer toClient = ByteBuffer.allocate(65_536);
        client.beginHandshake();
        server.beginHandshake();
        while (isShaking(client) || isShaking(server)) {
            step(client, toClient, toServer);
            step(server, toServer, toClient);
        }
        return server.getSession();
    }

    private static boolean isShaking(SSLEngine engine) {
        return engine.getHandshakeStatus() != HandshakeStatus.NOT_HANDSHAKING;
    }

    private static void step(SSLEngine engine, ByteBuffer in, ByteBuffer out) throws SSLException {
        switch (engine.getHandshakeStatus()) {
            case NEED_WRAP -> engine.wrap(ByteBuffer.allocate(0), out);
            case NEED_TASK -> {
                for (Runnable task = engine.getDelegatedTask();
                        task != null;
                        task = engine.getDelegatedTask()) {
                    task.run();
                }
            }
            default -> {
                in.flip();
                engine.unwrap(in, ByteBuffer.allocate(65_536));
                in.compact();
            }
        }
    }
}
