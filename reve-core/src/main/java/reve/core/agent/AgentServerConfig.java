package reve.core.agent;

import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.nio.file.Path;
import java.time.Duration;
import java.util.Optional;

/**
 * Where the server listens and what it takes from a client. The limits are those that PROTOCOL.md promises; tests
 * set smaller ones.
 *
 * @param address port 0 takes any free one
 * @param maxConnections open connections, whether welcomed or not; and clients, whether connected or not
 * @param helloBytes most bytes before the hello is complete
 * @param hello longest wait for the hello
 * @param lineBytes longest line from a client
 * @param line longest time from a line's first byte to its last
 * @param idle silence after which a client is pinged, and after as much again cut off
 * @param write longest time that one write may take
 * @param grace longest time that the body of an agent whose connection broke may wait for it
 * @param deadline longest time that an agent in lock-step may have the world wait
 * @param linger how long a finished connection may take to go
 * @param messagesPerSecond most messages from one client, see {@link Quota}
 * @param actsInFlight most acts and other commands of one client that wait for their result
 * @param outboxMessages most messages of one agent that wait to be written
 * @param outboxBytes and most bytes of them
 * @param maxErrors refused messages after which a connection ends
 * @param audit the file to which a record of all that clients are told is appended
 * @param security how clients and server know each other
 */
public record AgentServerConfig(InetSocketAddress address, int maxConnections, int helloBytes, Duration hello,
        int lineBytes, Duration line, Duration idle, Duration write, Duration grace, Duration deadline, Duration linger,
        int messagesPerSecond, int actsInFlight, int outboxMessages, int outboxBytes, int maxErrors,
        Optional<Path> audit, AgentSecurity security) {

    /**
     * @throws IllegalArgumentException if other machines reach the address and there are no tokens or no TLS, or a
     *     limit is not positive
     */
    public AgentServerConfig {
        if (address.isUnresolved()) {
            throw new IllegalArgumentException("there is no address of " + address.getHostString());
        }
        if (!address.getAddress().isLoopbackAddress() && !security.isComplete()) {
            throw new IllegalArgumentException("agents cannot be served on " + address.getHostString()
                    + " without tokens and TLS: other machines reach it");
        }
        requirePositive("maxConnections", maxConnections);
        requirePositive("helloBytes", helloBytes);
        requirePositive("hello", hello.toMillis());
        requirePositive("lineBytes", lineBytes);
        requirePositive("line", line.toMillis());
        requirePositive("idle", idle.toMillis());
        requirePositive("write", write.toMillis());
        requirePositive("grace", grace.toMillis());
        requirePositive("deadline", deadline.toMillis());
        requirePositive("linger", linger.toMillis());
        requirePositive("messagesPerSecond", messagesPerSecond);
        requirePositive("actsInFlight", actsInFlight);
        requirePositive("outboxMessages", outboxMessages);
        requirePositive("outboxBytes", outboxBytes);
        requirePositive("maxErrors", maxErrors);
    }

    /** The protocol's limits on 127.0.0.1. */
    public static AgentServerConfig onPort(int port) {
        return on(new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), port));
    }

    /** The protocol's limits on a loopback address. */
    public static AgentServerConfig on(InetSocketAddress address) {
        return on(address, AgentSecurity.NONE);
    }

    /** The protocol's limits on any address. */
    public static AgentServerConfig on(InetSocketAddress address, AgentSecurity security) {
        return new AgentServerConfig(address, 4096, 8 * 1024, Duration.ofSeconds(2), 64 * 1024,
                Duration.ofSeconds(10), Duration.ofSeconds(15), Duration.ofSeconds(5), Duration.ofSeconds(60),
                Duration.ofSeconds(10), Duration.ofSeconds(1), 4096, 64, 1024, 1024 * 1024, 8, Optional.empty(),
                security);
    }

    /** The same, with a record of all that clients are told. */
    public AgentServerConfig withAudit(Path file) {
        return new AgentServerConfig(address, maxConnections, helloBytes, hello, lineBytes, line, idle, write, grace,
                deadline, linger, messagesPerSecond, actsInFlight, outboxMessages, outboxBytes, maxErrors,
                Optional.of(file), security);
    }

    /** The same, with another longest time that an agent in lock-step may have the world wait. */
    public AgentServerConfig withDeadline(Duration longest) {
        return new AgentServerConfig(address, maxConnections, helloBytes, hello, lineBytes, line, idle, write, grace,
                longest, linger, messagesPerSecond, actsInFlight, outboxMessages, outboxBytes, maxErrors, audit, security);
    }

    private static void requirePositive(String name, long value) {
        if (value <= 0) {
            throw new IllegalArgumentException("limit " + name + " is " + value + ", expected more than 0");
        }
    }
}
