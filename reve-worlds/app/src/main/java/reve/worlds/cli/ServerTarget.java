// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Join;
import reve.agent.Trust;
import reve.core.text.Rounded;

import java.io.IOException;
import java.net.UnknownHostException;
import java.nio.file.Path;
import java.time.Duration;
import java.util.Optional;

/** The options by which a command reaches a server as a client of the role control. */
class ServerTarget {
    private static final String TOKEN = "REVE_TOKEN";
    private static final String NAME = "control";
    private static final int MAX_PORT = 65_535;
    private static final double MIN_TIMEOUT = 0.1;
    private static final double MAX_TIMEOUT = 3600;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--host",
            paramLabel = "ADDRESS",
            defaultValue = "127.0.0.1",
            description = "Host of the server (default: ${DEFAULT-VALUE}).")
    private String host = "";

    @Option(
            names = "--port",
            paramLabel = "N",
            defaultValue = ListenOptions.DEFAULT_PORT,
            description = "Agent port of the server (default: ${DEFAULT-VALUE}).")
    private int port;

    @Option(
            names = "--name",
            paramLabel = "NAME",
            description =
                    "Client name of the sender (default: "
                            + NAME
                            + ", or a free name that begins with it). A token is taken from "
                            + TOKEN
                            + ".")
    private Optional<String> name = Optional.empty();

    @Option(
            names = "--tls-trust",
            paramLabel = "FILE",
            description =
                    "Use TLS, and verify the server with the certificates in this file (PEM).")
    private Optional<Path> trust = Optional.empty();

    @Option(
            names = "--answer-timeout",
            paramLabel = "S",
            defaultValue = "10",
            description =
                    "Longest wait for an answer of the server [s] (default: ${DEFAULT-VALUE}).")
    private double timeout;

    /**
     * Returns the nodes and worlds of the server's cluster. Joins no world, so no world wakes.
     *
     * @throws IOException if no server listens there
     * @throws AgentException if the server refuses the question
     */
    ActResult cluster() throws IOException {
        return asked(() -> AgentClient.cluster(host, port, join(name.orElse(NAME))));
    }

    /**
     * Joins a world.
     *
     * @param world empty if the server has one world only
     * @throws IOException if no server listens there
     * @throws AgentException if the server refuses the client
     */
    AgentClient connect(Optional<String> world) throws IOException {
        return asked(
                () -> {
                    try {
                        return AgentClient.connect(host, port, join(name.orElse(NAME), world));
                    } catch (AgentException refused) {
                        // Another command may wait for its answer.
                        if (!refused.code().equals("name-taken")
                                || name.isPresent()
                                || hasToken()) {
                            throw refused;
                        }
                        String free = NAME + "-" + ProcessHandle.current().pid();
                        return AgentClient.connect(host, port, join(free, world));
                    }
                });
    }

    /** A conversation with a server. */
    private interface Talk<T> {
        T with() throws IOException;
    }

    private <T> T asked(Talk<T> talk) throws IOException {
        if (port < 1 || port > MAX_PORT) {
            throw new ParameterException(
                    spec.commandLine(), "--port is " + port + ", expected 1 to " + MAX_PORT);
        }
        if (!(timeout >= MIN_TIMEOUT && timeout <= MAX_TIMEOUT)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--answer-timeout is "
                            + Rounded.of(timeout)
                            + ", expected "
                            + Rounded.of(MIN_TIMEOUT)
                            + " to "
                            + Rounded.of(MAX_TIMEOUT)
                            + " s");
        }
        try {
            return talk.with();
        } catch (UnknownHostException e) {
            throw new IOException("--host " + host + ": there is no such address", e);
        }
    }

    private static boolean hasToken() {
        return System.getenv(TOKEN) != null;
    }

    private Join join(String as, Optional<String> world) throws IOException {
        Join join = join(as);
        return world.isPresent() ? join.withWorld(world.get()) : join;
    }

    private Join join(String as) throws IOException {
        Join join =
                Join.as(as)
                        .withRole("control")
                        .withPatience(Duration.ofNanos(Math.round(timeout * 1e9)));
        if (hasToken()) {
            join = join.withToken(System.getenv(TOKEN));
        }
        return trust.isPresent() ? join.withTls(Trust.file(trust.get())) : join;
    }

    /** Returns the failure of a command that the server has refused. */
    IOException refused(AgentException refused) {
        return new IOException(host + ":" + port + " answers " + refused.getMessage(), refused);
    }
}
