// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.agent.AgentServerConfig;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.ServerTls;
import reve.core.agent.auth.TokenFile;
import reve.worlds.Product;

import java.io.IOException;
import java.net.BindException;
import java.net.InetSocketAddress;
import java.nio.file.Path;
import java.util.Map;
import java.util.Optional;

/** The options for the server's address, authentication and encryption. */
final class ListenOptions {
    /** Default TCP port of the protocol, see agents/protocol/PROTOCOL.md. */
    static final String DEFAULT_PORT = "7777";

    private static final int MAX_PORT = 65_535;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--port",
            paramLabel = "N",
            defaultValue = DEFAULT_PORT,
            description = "Port for agents; 0 selects a free one (default: ${DEFAULT-VALUE}).")
    private int port;

    @Option(
            names = "--web",
            paramLabel = "N",
            description =
                    "Serve a page that shows and controls the worlds on this port of the same"
                            + " address; 0 selects a free one.")
    private Optional<Integer> web = Optional.empty();

    @Option(
            names = "--listen",
            paramLabel = "ADDRESS",
            defaultValue = "127.0.0.1",
            description =
                    "Address for agents (default: ${DEFAULT-VALUE}). "
                            + "An address other than loopback requires tokens and TLS.")
    private String address = "";

    @Option(
            names = "--tokens",
            paramLabel = "FILE",
            description = "Require a token of this file from each client, see `token --help`.")
    private Optional<Path> tokens = Optional.empty();

    @Option(
            names = "--tls-certificate",
            paramLabel = "FILE",
            description =
                    "Use TLS with this certificate (PEM, with its intermediate certificates).")
    private Optional<Path> certificate = Optional.empty();

    @Option(
            names = "--tls-key",
            paramLabel = "FILE",
            description = "Private key of the certificate (PEM).")
    private Optional<Path> key = Optional.empty();

    /** Returns the files that these options name, by option. */
    Map<String, Optional<Path>> files() {
        return Map.of("--tokens", tokens, "--tls-certificate", certificate, "--tls-key", key);
    }

    /** Returns the address of the web page; empty if none is served. */
    Optional<InetSocketAddress> web() {
        if (web.isPresent() && (web.get() < 0 || web.get() > MAX_PORT)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--web is " + web.get() + ", expected 0 (any free one) to " + MAX_PORT);
        }
        return web.map(number -> new InetSocketAddress(address, number));
    }

    /**
     * Returns the server's configuration, with the protocol's limits changed as the options
     * require.
     *
     * @throws ParameterException if the options contradict each other
     * @throws BindException if other machines can reach the address without tokens or without TLS
     * @throws IOException if a file cannot be used; the message gives the reason
     */
    AgentServerConfig config() throws IOException {
        if (port < 0 || port > MAX_PORT) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--port is " + port + ", expected 0 (any free one) to " + MAX_PORT);
        }
        if (certificate.isPresent() != key.isPresent()) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--tls-certificate and --tls-key belong together; found only one of them");
        }
        var listen = new InetSocketAddress(address, port);
        if (listen.isUnresolved()) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--listen "
                            + address
                            + ": there is no such address; expected 127.0.0.1, 0.0.0.0, or a name");
        }
        if (!listen.getAddress().isLoopbackAddress()
                && (tokens.isEmpty() || certificate.isEmpty())) {
            throw new BindException(howToListen());
        }
        return AgentServerConfig.on(listen, security());
    }

    private AgentSecurity security() throws IOException {
        return new AgentSecurity(
                tokens.isPresent() ? Optional.of(TokenFile.open(tokens.get())) : Optional.empty(),
                certificate.isPresent()
                        ? Optional.of(ServerTls.of(certificate.get(), key.orElseThrow()))
                        : Optional.empty());
    }

    private String howToListen() {
        var how =
                new StringBuilder(
                        "--listen "
                                + address
                                + ": other machines reach it, so agents take tokens and TLS there."
                                + " Run");
        if (tokens.isEmpty()) {
            how.append("\n  ")
                    .append(Product.command())
                    .append(" token new NAME --file tokens.json");
        }
        if (certificate.isEmpty()) {
            how.append("\n  openssl req -x509 -nodes -newkey ec")
                    .append(" -pkeyopt ec_paramgen_curve:P-256 -days 365 -subj /CN=HOST")
                    .append(" -addext subjectAltName=DNS:HOST -keyout server.key -out server.crt");
        }
        return how.append("\nand add")
                .append(tokens.isEmpty() ? " --tokens tokens.json" : "")
                .append(
                        certificate.isEmpty()
                                ? " --tls-certificate server.crt --tls-key server.key"
                                : "")
                .append("\n(NAME: the agent's; HOST: what agents call this machine).")
                .toString();
    }
}
