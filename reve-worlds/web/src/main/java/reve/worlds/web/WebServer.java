// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.http.HttpVersion;
import org.eclipse.jetty.server.ConnectionFactory;
import org.eclipse.jetty.server.HttpConfiguration;
import org.eclipse.jetty.server.HttpConnectionFactory;
import org.eclipse.jetty.server.Server;
import org.eclipse.jetty.server.ServerConnector;
import org.eclipse.jetty.server.SslConnectionFactory;
import org.eclipse.jetty.util.thread.QueuedThreadPool;
import org.eclipse.jetty.util.thread.VirtualThreadPool;
import org.eclipse.jetty.websocket.server.WebSocketUpgradeHandler;

import reve.core.agent.AgentServer;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.ServerTls;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.WorldPort;
import reve.core.file.CameraDescription;
import reve.worlds.server.HostPage;

import java.io.IOException;
import java.net.BindException;
import java.net.InetSocketAddress;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.function.Supplier;

/**
 * Server of the web page and of its WebSocket at {@code /world}. Text messages of the WebSocket are
 * lines of the agent protocol. They pass through the sessions of the agent server. Binary messages
 * contain the scene, for clients that perceive everything. The server of a node of a cluster also
 * serves the page of the nodes, {@code /nodes}.
 */
public final class WebServer implements HostPage, AutoCloseable {

    private static final String SOCKET = "/world";

    /** Time without traffic after which a connection without a WebSocket is closed. */
    private static final Duration IDLE = Duration.ofSeconds(10);

    /**
     * Time without traffic after which a WebSocket is closed. It is longer than the interval of the
     * agent server's pings.
     */
    private static final Duration SOCKET_IDLE = Duration.ofSeconds(60);

    private static final int MAX_LINE = 65_536;
    private static final int MAX_THREADS = 16;
    private static final int MAX_HEADER_BYTES = 8192;

    private final Server server;
    private final ServerConnector connector;
    private final boolean encrypted;
    private final InetSocketAddress address;
    private final Map<String, SceneFeed> feeds = new ConcurrentHashMap<>();
    private final List<WorldPort> ports = new CopyOnWriteArrayList<>();
    private final OpenPages pages = new OpenPages();

    /**
     * Starts the server.
     *
     * @param address address to listen on; port 0 selects a free port
     * @param security the same settings as for the agent server; TLS is required on addresses that
     *     other machines can reach
     * @param agents server whose sessions the page's clients use
     * @param worlds worlds that the page can show
     * @throws BindException naming the address if it is not available
     */
    public static WebServer start(
            InetSocketAddress address,
            AgentSecurity security,
            AgentServer agents,
            List<PageWorld> worlds)
            throws IOException {
        var server = new WebServer(address, security, agents, Optional::empty);
        worlds.forEach(world -> server.add(world.port(), world.camera()));
        server.start();
        return server;
    }

    /**
     * Starts the server of a node of a cluster, without a world, like {@link
     * #start(InetSocketAddress, AgentSecurity, AgentServer, List)}.
     *
     * @param cluster returns the cluster; empty until the node has joined it
     */
    public static WebServer start(
            InetSocketAddress address,
            AgentSecurity security,
            AgentServer agents,
            Supplier<Optional<ClusterPort>> cluster)
            throws IOException {
        var server = new WebServer(address, security, agents, cluster);
        server.start();
        return server;
    }

    private void start() throws IOException {
        try {
            server.start();
        } catch (Exception failed) {
            close();
            throw notBound(address, failed);
        }
    }

    private WebServer(
            InetSocketAddress address,
            AgentSecurity security,
            AgentServer agents,
            Supplier<Optional<ClusterPort>> cluster)
            throws IOException {
        Optional<ServerTls> tls = security.tls();
        if (!address.getAddress().isLoopbackAddress() && tls.isEmpty()) {
            throw new IllegalArgumentException(
                    "the page cannot be served on "
                            + address.getHostString()
                            + " without TLS: other machines reach it");
        }
        this.address = address;
        this.encrypted = tls.isPresent();
        var threads = new QueuedThreadPool(MAX_THREADS);
        threads.setName("page");
        threads.setDaemon(true);
        threads.setVirtualThreadsExecutor(new VirtualThreadPool());
        this.server = new Server(threads);
        var http = new HttpConfiguration();
        http.setSendServerVersion(false);
        http.setRequestHeaderSize(MAX_HEADER_BYTES);
        this.connector =
                new LimitedConnector(
                        server,
                        new Visitors(agents.roomForOtherServers(), agents::takeDescriptor),
                        factories(http, tls).toArray(FACTORIES));
        connector.setHost(address.getAddress().getHostAddress());
        connector.setPort(address.getPort());
        connector.setIdleTimeout(IDLE.toMillis());
        server.addConnector(connector);
        var guard = new HostGuard(address.getAddress().isLoopbackAddress());
        WebSocketUpgradeHandler sockets =
                WebSocketUpgradeHandler.from(
                        server,
                        container -> {
                            container.setMaxTextMessageSize(MAX_LINE);
                            container.setMaxBinaryMessageSize(Watcher.MAX_REQUEST_BYTES);
                            container.setIdleTimeout(SOCKET_IDLE);
                            container.addMapping(
                                    SOCKET,
                                    (request, response, callback) -> {
                                        // Extensions of the WebSocket are refused, because the only
                                        // common one is compression. Compression would take more
                                        // time than it saves on a loopback connection.
                                        response.setExtensions(List.of());
                                        return new PageSocket(
                                                agents,
                                                feeds,
                                                (InetSocketAddress)
                                                        request.getConnectionMetaData()
                                                                .getRemoteSocketAddress(),
                                                pages,
                                                MeteredEndPoint.budgetOf(request));
                                    });
                        });
        sockets.setHandler(new PageFiles());
        var orders = new ClusterPaths(cluster, security.tokens());
        orders.setHandler(sockets);
        var operations = new Operations(ports, agents, security.tokens());
        operations.setHandler(orders);
        guard.setHandler(operations);
        var turns = new Turns();
        turns.setHandler(guard);
        server.setHandler(turns);
    }

    private static final ConnectionFactory[] FACTORIES = {};

    private static List<ConnectionFactory> factories(
            HttpConfiguration http, Optional<ServerTls> tls) {
        var factories = new ArrayList<ConnectionFactory>();
        tls.ifPresent(
                keys ->
                        factories.add(
                                new SslConnectionFactory(
                                        new ServerKeys(keys), HttpVersion.HTTP_1_1.asString())));
        factories.add(new HttpConnectionFactory(http));
        return factories;
    }

    private static IOException notBound(InetSocketAddress address, Exception failed) {
        Throwable reason = failed;
        while (reason.getCause() != null) {
            reason = reason.getCause();
        }
        var unbound =
                new BindException(
                        "cannot serve the page on "
                                + address.getHostString()
                                + " port "
                                + address.getPort()
                                + ": "
                                + reason.getMessage()
                                + "; name another port (0: any free one)");
        unbound.initCause(failed);
        return unbound;
    }

    @Override
    public void add(WorldPort port, Optional<CameraDescription> camera) {
        feeds.put(port.world(), new SceneFeed(new PageWorld(port, camera)));
        ports.add(port);
    }

    @Override
    public void remove(String world) {
        ports.removeIf(port -> port.world().equals(world));
        SceneFeed feed = feeds.remove(world);
        if (feed != null) {
            feed.end();
        }
    }

    @Override
    public String address() {
        String host = address.getHostString();
        return (encrypted ? "https://" : "http://")
                + (host.contains(":") ? "[" + host + "]" : host)
                + ":"
                + connector.getLocalPort()
                + "/";
    }

    /** Returns the number of open connections. For tests. */
    int connections() {
        return connector.getConnectedEndPoints().size();
    }

    /** Closes all connections and frees the port. Idempotent. */
    @Override
    public void close() {
        try {
            server.stop();
        } catch (Exception failed) {
            throw new IllegalStateException("the page's server could not be stopped", failed);
        } finally {
            feeds.values().forEach(SceneFeed::close);
            pages.close();
        }
    }
}
