// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.util.ssl.SslContextFactory;

import reve.core.agent.auth.ServerTls;

import java.net.InetSocketAddress;

import javax.net.ssl.SSLEngine;

/**
 * The TLS settings of the web port. They are those of the agent server. The certificate file is
 * read again when it changes.
 */
final class ServerKeys extends SslContextFactory.Server {

    private final ServerTls tls;

    ServerKeys(ServerTls tls) {
        this.tls = tls;
        setSslContext(tls.context());
    }

    @Override
    public SSLEngine newSSLEngine() {
        return tls.engine();
    }

    @Override
    public SSLEngine newSSLEngine(String host, int port) {
        return tls.engine();
    }

    @Override
    public SSLEngine newSSLEngine(InetSocketAddress address) {
        return tls.engine();
    }
}
