package reve.core.agent;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermission;
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
import java.util.Base64;
import java.util.List;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import javax.net.ssl.KeyManagerFactory;
import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLEngine;

/**
 * Keeps connections private, with TLS 1.3, and shows clients the server's certificate. Any thread.
 */
public final class ServerTls {

    private static final String[] PROTOCOLS = {"TLSv1.3"};
    private static final char[] IN_MEMORY = "in memory".toCharArray();
    private static final Pattern KEY = Pattern.compile(
            "-----BEGIN PRIVATE KEY-----([A-Za-z0-9+/=\\s]+)-----END PRIVATE KEY-----");

    private final SSLContext context;

    private ServerTls(SSLContext context) {
        this.context = context;
    }

    /**
     * Reads both from PEM files.
     *
     * @param certificate the server's own first, then those that vouch for it
     * @param key the private one of the first certificate: PKCS#8, not encrypted, not readable by
     *     everybody
     * @throws IOException naming the file and what is wrong with it
     */
    public static ServerTls of(Path certificate, Path key) throws IOException {
        requireFile(certificate);
        requireFile(key);
        Certificate[] chain = chain(certificate);
        PrivateKey secret = key(key, chain[0].getPublicKey().getAlgorithm());
        try {
            if (!fit(secret, chain[0])) {
                throw new FileSystemException(key + " is not the key of the certificate in "
                        + certificate);
            }
            var store = KeyStore.getInstance("PKCS12");
            store.load(null, IN_MEMORY);
            store.setKeyEntry("server", secret, IN_MEMORY, chain);
            var keys = KeyManagerFactory.getInstance(KeyManagerFactory.getDefaultAlgorithm());
            keys.init(store, IN_MEMORY);
            var context = SSLContext.getInstance("TLS");
            context.init(keys.getKeyManagers(), null, null);
            return new ServerTls(context);
        } catch (GeneralSecurityException e) {
            throw new IOException(
                    "TLS with " + certificate + " and " + key + ": " + e.getMessage(), e);
        }
    }

    /** The server's side of a new connection. */
    SSLEngine engine() {
        SSLEngine engine = context.createSSLEngine();
        engine.setUseClientMode(false);
        engine.setEnabledProtocols(PROTOCOLS);
        return engine;
    }

    private static void requireFile(Path file) throws IOException {
        if (!Files.exists(file) || Files.isDirectory(file)) {
            throw new NoSuchFileException("there is no file " + file + ", expected one in PEM");
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
            throw new FileSystemException(file + ": " + e.getMessage()
                    + "; expected valid certificates in PEM");
        }
    }

    private static PrivateKey key(Path file, String algorithm) throws IOException {
        if (Files.getPosixFilePermissions(file).contains(PosixFilePermission.OTHERS_READ)) {
            throw new FileSystemException(file + " can be read by everybody; run `chmod 600 "
                    + file + "`");
        }
        Matcher pem = KEY.matcher(Files.readString(file, StandardCharsets.ISO_8859_1));
        if (!pem.find()) {
            throw new FileSystemException(file
                    + " holds no `BEGIN PRIVATE KEY`; run `openssl pkcs8 -topk8 -nodes -in "
                    + file + " -out NEW` and use that");
        }
        try {
            byte[] bytes = Base64.getMimeDecoder().decode(pem.group(1));
            return KeyFactory.getInstance(algorithm)
                    .generatePrivate(new PKCS8EncodedKeySpec(bytes));
        } catch (GeneralSecurityException | IllegalArgumentException e) {
            throw new FileSystemException(file + " holds no key of the certificate's kind ("
                    + algorithm + "): " + e.getMessage());
        }
    }

    private static boolean fit(PrivateKey key, Certificate certificate)
            throws GeneralSecurityException {
        byte[] text = "signed".getBytes(StandardCharsets.US_ASCII);
        var signature = Signature.getInstance(switch (key.getAlgorithm()) {
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
