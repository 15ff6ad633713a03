// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.io.IOException;
import java.io.InputStream;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.security.GeneralSecurityException;
import java.security.KeyStore;
import java.security.cert.Certificate;
import java.security.cert.CertificateFactory;

import javax.net.ssl.SSLContext;
import javax.net.ssl.TrustManagerFactory;

/** TLS trust anchors. */
public final class Trust {

    private Trust() {}

    /** Returns the trust anchors of the Java runtime. */
    public static SSLContext system() {
        try {
            return SSLContext.getDefault();
        } catch (GeneralSecurityException e) {
            throw new IllegalStateException("this Java runtime has no TLS", e);
        }
    }

    /**
     * Returns an SSL context that trusts only the certificates in a file.
     *
     * @param file PEM file with the server's own certificate, or with that of its issuer
     * @throws IOException naming the file, if it cannot be read or contains no certificate
     */
    public static SSLContext file(Path file) throws IOException {
        if (Files.exists(file) && !Files.isRegularFile(file)) {
            // Reading a pipe would block until another process writes to it.
            throw new IOException(file + " is no file, expected a file of certificates (PEM)");
        }
        try (InputStream in = Files.newInputStream(file)) {
            var store = KeyStore.getInstance("PKCS12");
            store.load(null, null);
            for (Certificate certificate :
                    CertificateFactory.getInstance("X.509").generateCertificates(in)) {
                store.setCertificateEntry("trusted " + store.size(), certificate);
            }
            if (store.size() == 0) {
                throw new IOException(file + " holds no certificate, expected PEM");
            }
            var trust = TrustManagerFactory.getInstance(TrustManagerFactory.getDefaultAlgorithm());
            trust.init(store);
            var context = SSLContext.getInstance("TLS");
            context.init(null, trust.getTrustManagers(), null);
            return context;
        } catch (NoSuchFileException e) {
            throw new IOException("there is no file " + file + " of certificates to trust", e);
        } catch (GeneralSecurityException e) {
            throw new IOException(file + ": " + e.getMessage(), e);
        }
    }
}
