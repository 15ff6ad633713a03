// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.agent.auth.ServerTls;

import java.io.FileInputStream;
import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.security.KeyStore;
import java.security.cert.CertificateFactory;
import java.util.ArrayList;
import java.util.List;

import javax.net.ssl.SSLContext;
import javax.net.ssl.TrustManagerFactory;

/** A self-signed certificate for this machine, made by the command that the documents give. */
public record Certificate(Path certificate, Path key) {

    static Certificate make(Path folder, String name) throws IOException, InterruptedException {
        return make(folder, name, "ec", "-pkeyopt", "ec_paramgen_curve:P-256");
    }

    /**
     * @param kind of key, as openssl names it
     */
    static Certificate make(Path folder, String name, String... kind)
            throws IOException, InterruptedException {
        var made = new Certificate(folder.resolve(name + ".crt"), folder.resolve(name + ".key"));
        var command =
                new ArrayList<>(
                        List.of(
                                "openssl",
                                "req",
                                "-x509",
                                "-nodes",
                                "-days",
                                "2",
                                "-keyout",
                                made.key.toString(),
                                "-out",
                                made.certificate.toString(),
                                "-subj",
                                "/CN=localhost",
                                "-addext",
                                "subjectAltName=DNS:localhost,IP:127.0.0.1",
                                "-newkey"));
        command.addAll(List.of(kind));
        Process openssl = new ProcessBuilder(command).redirectErrorStream(true).start();
        openssl.getOutputStream().close();
        String said = new String(openssl.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        if (openssl.waitFor() != 0) {
            throw new IOException(String.join(" ", command) + ": " + said);
        }
        return made;
    }

    ServerTls tls() throws IOException {
        return ServerTls.of(certificate, key);
    }

    /** Returns the trust anchors of a client that trusts only this certificate. */
    SSLContext trusting() throws Exception {
        var store = KeyStore.getInstance("PKCS12");
        store.load(null, null);
        try (var in = new FileInputStream(certificate.toFile())) {
            store.setCertificateEntry(
                    "server", CertificateFactory.getInstance("X.509").generateCertificate(in));
        }
        var trust = TrustManagerFactory.getInstance(TrustManagerFactory.getDefaultAlgorithm());
        trust.init(store);
        SSLContext context = SSLContext.getInstance("TLS");
        context.init(null, trust.getTrustManagers(), null);
        return context;
    }
}
