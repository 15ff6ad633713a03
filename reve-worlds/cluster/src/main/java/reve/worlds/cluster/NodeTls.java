// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import com.typesafe.config.Config;

import org.apache.pekko.actor.ActorSystem;
import org.apache.pekko.remote.artery.tcp.SSLEngineProvider;

import reve.core.agent.auth.ServerTls;

import scala.Option;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.Path;

import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLEngine;
import javax.net.ssl.SSLParameters;
import javax.net.ssl.SSLSession;

/**
 * Mutual TLS 1.3 between nodes. Both sides need a certificate that an authority of the cluster has
 * signed. The node that connects also checks that the certificate is for the host that it calls.
 *
 * <p>Pekko creates the object, from the section {@code reve.tls} of the configuration. For any
 * thread.
 */
public final class NodeTls implements SSLEngineProvider {
    private static final String[] PROTOCOLS = {"TLSv1.3"};

    private final SSLContext context;

    /**
     * The files of a node.
     *
     * @param certificate PEM: the node's certificate, with its intermediate certificates
     * @param key PEM: the private key of the certificate, readable by its owner only
     * @param authority PEM: the certificates of the authorities that sign the nodes' certificates
     */
    public record Files(Path certificate, Path key, Path authority) {
        /**
         * Reads the files.
         *
         * @throws IOException naming the file and the error
         */
        public SSLContext context() throws IOException {
            return ServerTls.mutual(certificate, key, authority);
        }
    }

    /** Reads the files that the configuration names. */
    public NodeTls(ActorSystem system) {
        this(contextOf(system.settings().config()));
    }

    NodeTls(SSLContext context) {
        this.context = context;
    }

    private static SSLContext contextOf(Config config) {
        try {
            return new Files(
                            Path.of(config.getString("reve.tls.certificate")),
                            Path.of(config.getString("reve.tls.key")),
                            Path.of(config.getString("reve.tls.authority")))
                    .context();
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }

    @Override
    public SSLEngine createServerSSLEngine(String host, int port) {
        SSLEngine engine = context.createSSLEngine(host, port);
        engine.setUseClientMode(false);
        engine.setEnabledProtocols(PROTOCOLS);
        engine.setNeedClientAuth(true);
        return engine;
    }

    @Override
    public SSLEngine createClientSSLEngine(String host, int port) {
        SSLEngine engine = context.createSSLEngine(host, port);
        engine.setUseClientMode(true);
        engine.setEnabledProtocols(PROTOCOLS);
        SSLParameters parameters = engine.getSSLParameters();
        parameters.setEndpointIdentificationAlgorithm("HTTPS");
        engine.setSSLParameters(parameters);
        return engine;
    }

    /** Accepts the session, because the handshake has verified both certificates. */
    @Override
    public Option<Throwable> verifyClientSession(String host, SSLSession session) {
        return Option.empty();
    }

    /** Accepts the session, because the handshake has verified both certificates. */
    @Override
    public Option<Throwable> verifyServerSession(String host, SSLSession session) {
        return Option.empty();
    }
}
