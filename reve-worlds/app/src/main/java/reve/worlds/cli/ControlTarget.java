// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Join;
import reve.agent.Trust;

import java.io.IOException;
import java.net.UnknownHostException;
import java.nio.file.Path;
import java.util.Optional;

/** The options by which a command reaches a running world as a client of the role control. */
final class ControlTarget {
    private static final String TOKEN = "REVE_TOKEN";
    private static final int MAX_PORT = 65_535;

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
            names = "--world",
            paramLabel = "NAME",
            description = "Name of the world, if the server has several.")
    private Optional<String> world = Optional.empty();

    @Option(
            names = "--name",
            paramLabel = "NAME",
            defaultValue = "control",
            description =
                    "Client name of the sender (default: ${DEFAULT-VALUE}). "
                            + "A token is taken from "
                            + TOKEN
                            + ".")
    private String name = "";

    @Option(
            names = "--tls-trust",
            paramLabel = "FILE",
            description =
                    "Use TLS, and verify the server with the certificates in this file (PEM).")
    private Optional<Path> trust = Optional.empty();

    /**
     * Connects with the role control.
     *
     * @throws IOException if no server listens there
     * @throws reve.agent.AgentException if the server refuses the client
     */
    AgentClient connect() throws IOException {
        if (port < 1 || port > MAX_PORT) {
            throw wrong("--port is " + port + ", expected 1 to " + MAX_PORT);
        }
        Join join = join();
        try {
            return AgentClient.connect(host, port, join);
        } catch (UnknownHostException e) {
            throw new IOException("--host " + host + ": there is no such address", e);
        }
    }

    private Join join() throws IOException {
        Join join = Join.as(name).withRole("control");
        if (world.isPresent()) {
            join = join.withWorld(world.get());
        }
        if (System.getenv(TOKEN) != null) {
            join = join.withToken(System.getenv(TOKEN));
        }
        return trust.isPresent() ? join.withTls(Trust.file(trust.get())) : join;
    }

    /** Returns the failure of a command that the server has refused. */
    IOException refused(AgentException refused) {
        return new IOException(host + ":" + port + " answers " + refused.getMessage(), refused);
    }

    private ParameterException wrong(String problem) {
        return new ParameterException(spec.commandLine(), problem);
    }
}
