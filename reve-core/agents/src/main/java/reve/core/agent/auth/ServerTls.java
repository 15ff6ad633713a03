// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.security.GeneralSecurityException;
import java.security.KeyFactory;
import java.security.KeyStore;
import java.security.PrivateKey;
import java.security.Signature;
import java.security.cert.Certificate;
import java.security.cert.CertificateException;
import java.security.cert.CertificateFactory;
import java.security.cert.X509Certificate;
import java.security.spec.PKCS8EncodedKeySpec;
import java.time.Instant;
import java.time.InstantSource;
import java.util.Base64;
import java.util.List;
import java.util.Optional;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

import javax.net.ssl.KeyManagerFactory;
import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLEngine;
import javax.net.ssl.TrustManager;
import javax.net.ssl.TrustManagerFactory;

/**
 * TLS 1.3 with the server's certificate. Reads the files of certificate and private key again when
 * they change. New connections use the new pair. An invalid new pair is ignored, and the previous
 * pair stays in use. {@link #engine} may be called on any thread, all other methods on the event
 * loop's thread.
 */
public final class ServerTls {

    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");
    private static final String[] PROTOCOLS = {"TLSv1.3"};
    private static final char[] IN_MEMORY = "in memory".toCharArray();
    private static final Pattern KEY =
            Pattern.compile(
                    "-----BEGIN PRIVATE KEY-----([A-Za-z0-9+/=\\s]+)-----END PRIVATE KEY-----");

    /**
     * Maximum size of the file of a certificate chain or a key [bytes]. It is enough for about
     * twenty certificates.
     */
    private static final int MOST_BYTES = 65_536;

    private final Path certificate;
    private final Path key;
    private final InstantSource clock;
    private final PatientReader reader;
    private volatile Pair pair;
    private Versions read;
    private Versions seen;
    private Optional<String> problem = Optional.empty();

    /** Why the files cannot be read now; empty if they can. */
    private Optional<String> slow = Optional.empty();

    /**
     * The TLS context of one version of the files, with its expiry.
     *
     * @param expires end of the certificate's validity
     */
    private record Pair(SSLContext context, Instant expires) {}

    /** Versions of the certificate file and the key file; empty for a missing file. */
    private record Versions(Optional<FileVersion> certificate, Optional<FileVersion> key) {}

    private ServerTls(Path certificate, Path key, InstantSource clock) throws IOException {
        this.certificate = certificate;
        this.key = key;
        this.clock = clock;
        this.reader = new PatientReader(certificate);
        this.read = versions();
        this.seen = read;
        this.pair = read(certificate, key);
    }

    /**
     * Reads certificate and private key from PEM files.
     *
     * @param certificate the server's certificate first, then its issuers
     * @param key private key of the first certificate: PKCS#8, not encrypted, readable by its owner
     *     only
     * @throws IOException naming the file and the error
     */
    public static ServerTls of(Path certificate, Path key) throws IOException {
        return of(certificate, key, InstantSource.system());
    }

    /**
     * Reads the files like {@link #of(Path, Path)}, with another clock for the check of validity.
     */
    public static ServerTls of(Path certificate, Path key, InstantSource clock) throws IOException {
        return new ServerTls(certificate, key, clock);
    }

    /**
     * Reads both files again if one has changed since they were read. Reads nothing if a file has
     * changed since the previous call. The operator replaces the two files one after the other, so
     * the second file may still be old.
     */
    public void refresh() {
        try {
            Versions now = reader.read(this::versions);
            if (now.equals(seen) && !now.equals(read)) {
                readAgain(now);
            }
            seen = now;
            slow = Optional.empty();
        } catch (IOException e) {
            slow = Optional.of(unchanged(e));
        }
    }

    private void readAgain(Versions now) throws PatientReader.SlowException {
        try {
            pair = reader.read(() -> read(certificate, key));
            problem = Optional.empty();
            LOG.info("{} and {} were read again", certificate, key);
        } catch (PatientReader.SlowException e) {
            throw e;
        } catch (IOException e) {
            problem = Optional.of(unchanged(e));
        }
        read = now;
    }

    private static String unchanged(IOException e) {
        return "connections still use the certificate read before: " + e.getMessage();
    }

    /**
     * Returns why the certificate in the file is not in use, or why clients refuse it; empty if
     * there is no problem.
     */
    public Optional<String> problem() {
        if (slow.isPresent()) {
            return slow;
        }
        Instant expires = pair.expires;
        return problem.isPresent() || clock.instant().isBefore(expires)
                ? problem
                : Optional.of(
                        "the certificate of "
                                + certificate
                                + " has expired ("
                                + expires
                                + "), and clients refuse it; replace it and its key");
    }

    /** Returns the message for the operator that a problem has ended. */
    public String solved() {
        return "new connections use the certificate of "
                + certificate
                + ", which expires "
                + pair.expires;
    }

    private Versions versions() {
        return new Versions(version(certificate), version(key));
    }

    private static Optional<FileVersion> version(Path file) {
        try {
            return Optional.of(FileVersion.of(file));
        } catch (IOException e) {
            return Optional.empty();
        }
    }

    private static Pair read(Path certificate, Path key) throws IOException {
        requireFile(certificate);
        requireFile(key);
        Certificate[] chain = chain(certificate);
        return new Pair(
                context(certificate, key, chain, null),
                ((X509Certificate) chain[0]).getNotAfter().toInstant());
    }

    /**
     * Returns the context of one side of a connection whose sides both present certificates.
     *
     * @param certificate certificate of this side first, then its issuers
     * @param key private key of the first certificate, as in {@link #of(Path, Path)}
     * @param authorities certificates of the issuers that this side trusts
     * @throws IOException naming the file and the error
     */
    public static SSLContext mutual(Path certificate, Path key, Path authorities)
            throws IOException {
        requireFile(certificate);
        requireFile(key);
        requireFile(authorities);
        try {
            var trusted = KeyStore.getInstance("PKCS12");
            trusted.load(null, IN_MEMORY);
            for (Certificate each : chain(authorities)) {
                trusted.setCertificateEntry("authority " + trusted.size(), each);
            }
            var trust = TrustManagerFactory.getInstance(TrustManagerFactory.getDefaultAlgorithm());
            trust.init(trusted);
            return context(certificate, key, chain(certificate), trust.getTrustManagers());
        } catch (GeneralSecurityException e) {
            throw new IOException("TLS with " + authorities + ": " + e.getMessage(), e);
        }
    }

    /**
     * Returns the TLS context of a certificate and its key.
     *
     * @param trust decides which certificates of the other side are accepted; null for the
     *     authorities of Java
     */
    private static SSLContext context(
            Path certificate, Path key, Certificate[] chain, TrustManager @Nullable [] trust)
            throws IOException {
        PrivateKey secret = key(key, chain[0].getPublicKey().getAlgorithm());
        try {
            if (!fit(secret, chain[0])) {
                throw new FileSystemException(
                        key + " is not the key of the certificate in " + certificate);
            }
            var store = KeyStore.getInstance("PKCS12");
            store.load(null, IN_MEMORY);
            store.setKeyEntry("server", secret, IN_MEMORY, chain);
            var keys = KeyManagerFactory.getInstance(KeyManagerFactory.getDefaultAlgorithm());
            keys.init(store, IN_MEMORY);
            var context = SSLContext.getInstance("TLS");
            context.init(keys.getKeyManagers(), trust, null);
            return context;
        } catch (GeneralSecurityException e) {
            throw new IOException(
                    "TLS with " + certificate + " and " + key + ": " + e.getMessage(), e);
        }
    }

    /** Returns the TLS context with the certificate and key in use. For any thread. */
    public SSLContext context() {
        return pair.context;
    }

    /** Creates the server's TLS engine for a new connection. */
    public SSLEngine engine() {
        SSLEngine engine = pair.context.createSSLEngine();
        engine.setUseClientMode(false);
        engine.setEnabledProtocols(PROTOCOLS);
        return engine;
    }

    private static void requireFile(Path file) throws IOException {
        if (!Files.exists(file) || Files.isDirectory(file)) {
            throw new NoSuchFileException("there is no file " + file + ", expected one in PEM");
        }
        if (!Files.isRegularFile(file)) { // reading a pipe would block until a writer opens it
            throw new FileSystemException(
                    file + " is a pipe or a device, expected a file in PEM; " + "name that file");
        }
        if (Files.size(file) == 0) { // for example a file of /proc, which may never end
            throw new FileSystemException(file + " is empty, expected a file in PEM");
        }
        if (Files.size(file) > MOST_BYTES) { // the parser takes minutes for megabytes
            throw new FileSystemException(
                    file
                            + " has "
                            + Files.size(file)
                            + " bytes, expected a file in PEM of at most "
                            + MOST_BYTES);
        }
    }

    private static Certificate[] chain(Path file) throws IOException {
        try (InputStream in = Files.newInputStream(file)) {
            var certificates =
                    List.copyOf(CertificateFactory.getInstance("X.509").generateCertificates(in));
            if (certificates.isEmpty()) {
                throw new FileSystemException(file + " holds no certificate, expected PEM");
            }
            ((X509Certificate) certificates.getFirst()).checkValidity();
            return certificates.toArray(Certificate[]::new);
        } catch (CertificateException e) {
            throw new FileSystemException(
                    file + ": " + e.getMessage() + "; expected valid certificates in PEM");
        }
    }

    private static PrivateKey key(Path file, String algorithm) throws IOException {
        FileVersion version = FileVersion.of(file);
        if (version.isOpenToOthers()) {
            throw new FileSystemException(version.openToOthers(file));
        }
        String text = Files.readString(file, StandardCharsets.ISO_8859_1);
        Matcher pem = KEY.matcher(text);
        if (!pem.find()) {
            if (text.contains("-----BEGIN PRIVATE KEY-----")) {
                throw new FileSystemException(
                        file
                                + " is incomplete or damaged: found `BEGIN PRIVATE KEY`, expected"
                                + " base64 and then `END PRIVATE KEY`; copy the key to another"
                                + " file and rename that file");
            }
            throw new FileSystemException(
                    file
                            + " holds no `BEGIN PRIVATE KEY`; run `openssl pkcs8 -topk8 -nodes -in "
                            + file
                            + " -out NEW` and use that");
        }
        try {
            byte[] bytes = Base64.getMimeDecoder().decode(pem.group(1));
            return KeyFactory.getInstance(algorithm)
                    .generatePrivate(new PKCS8EncodedKeySpec(bytes));
        } catch (GeneralSecurityException | IllegalArgumentException e) {
            throw new FileSystemException(
                    file
                            + " holds no valid key of the certificate's kind, "
                            + algorithm
                            + "; name the key for which the certificate was made");
        }
    }

    private static boolean fit(PrivateKey key, Certificate certificate)
            throws GeneralSecurityException {
        byte[] text = "signed".getBytes(StandardCharsets.US_ASCII);
        var signature =
                Signature.getInstance(
                        switch (key.getAlgorithm()) {
                            case "RSA" -> "SHA256withRSA";
                            case "EC" -> "SHA256withECDSA";
                            default -> key.getAlgorithm();
                        });
        signature.initSign(key);
        signature.update(text);
        byte[] signed = signature.sign();
        signature.initVerify(certificate.getPublicKey());
        signature.update(text);
        return signature.verify(signed);
    }
}
