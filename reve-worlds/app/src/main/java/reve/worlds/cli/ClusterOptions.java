// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.text.Rounded;
import reve.worlds.cluster.NodeAddress;
import reve.worlds.cluster.NodeSettings;
import reve.worlds.cluster.NodeTls;

import java.io.IOException;
import java.net.BindException;
import java.net.UnknownHostException;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The options of a server that is a node of a cluster. */
final class ClusterOptions {
    private static final String STORE = "--store postgresql://USER@HOST:PORT/DATABASE";
    private static final String SLEEP_AFTER = "--sleep-after";
    private static final String WATCH = "--watch";
    private static final double MIN_SLEEP_AFTER = 1;
    private static final double MAX_SLEEP_AFTER = 2_592_000;

    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--cluster",
            paramLabel = "NAME",
            description =
                    "Join the cluster of this name, whose nodes share the worlds of a --store URL."
                            + " The worlds of a lost node run on the others.")
    private Optional<String> name = Optional.empty();

    @Option(
            names = "--cluster-listen",
            paramLabel = "HOST:PORT",
            description =
                    "Address at which the other nodes of the cluster reach this one; port 0 selects"
                            + " a free one (default: 127.0.0.1:0).")
    private Optional<String> listen = Optional.empty();

    @Option(
            names = "--seed",
            paramLabel = "HOST:PORT",
            description =
                    "A node of the cluster, through which this one joins. May be repeated. Without"
                            + " it, the node begins a cluster.")
    private List<String> seeds = new ArrayList<>();

    @Option(
            names = "--cluster-certificate",
            paramLabel = "FILE",
            description =
                    "Certificate of this node for TLS with the other nodes (PEM). Needed unless"
                            + " --cluster-listen is a loopback address.")
    private Optional<Path> certificate = Optional.empty();

    @Option(
            names = "--cluster-key",
            paramLabel = "FILE",
            description = "Private key of the node's certificate (PEM).")
    private Optional<Path> key = Optional.empty();

    @Option(
            names = "--cluster-ca",
            paramLabel = "FILE",
            description =
                    "Certificates of the authorities whose nodes this one accepts (PEM). Use an"
                            + " authority that signs nothing else.")
    private Optional<Path> authority = Optional.empty();

    @Option(
            names = SLEEP_AFTER,
            paramLabel = "SECONDS",
            description =
                    "Time without clients after which a world of this node sleeps [s]. A world that"
                            + " sleeps takes no memory and no processor, and its time stands still"
                            + " until a client asks for it (default: worlds never sleep).")
    private Optional<Double> sleepAfter = Optional.empty();

    @Option(
            names = WATCH,
            description =
                    "Run no worlds. Show copies of the cluster's worlds to observers, which the"
                            + " other nodes send here.")
    private boolean watches;

    /** Returns whether the server is a node of a cluster. */
    boolean isGiven() {
        return name.isPresent();
    }

    /**
     * Returns the settings of the node.
     *
     * @param store the store of the worlds, if one was given
     * @throws ParameterException if the options contradict each other
     * @throws BindException if other machines can reach the address without TLS
     * @throws IOException if a file of TLS cannot be used
     */
    NodeSettings settings(Optional<StoreArgument> store) throws IOException {
        if (store.flatMap(StoreArgument::url).isEmpty()) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--cluster takes "
                            + STORE
                            + "; found "
                            + store.map(named -> "--store " + named.given()).orElse("no --store"));
        }
        requireSleepAfter();
        NodeAddress address = parse("--cluster-listen", listen.orElse("127.0.0.1:0"));
        List<NodeAddress> known = seeds.stream().map(seed -> parse("--seed", seed)).toList();
        Optional<NodeTls.Files> tls = tls();
        requireReachable(address, tls.isPresent());
        try {
            return new NodeSettings(
                    name.orElseThrow(),
                    address,
                    known,
                    store.get().given(),
                    tls,
                    sleepAfter.map(seconds -> Duration.ofNanos(Math.round(seconds * 1e9))),
                    watches);
        } catch (IllegalArgumentException wrong) {
            throw new ParameterException(spec.commandLine(), wrong.getMessage());
        }
    }

    /**
     * Prints a warning if the node does not use TLS, because other programs of this machine can
     * then connect to it.
     */
    void warn(NodeSettings settings) {
        if (settings.tls().isPresent()) {
            return;
        }
        spec.commandLine()
                .getErr()
                .println(
                        "reve: the nodes of the cluster "
                                + settings.cluster()
                                + " talk without TLS: each user of this machine can join it."
                                + " Other machines cannot reach it");
        spec.commandLine().getErr().flush();
    }

    /** Returns the files that these options name, by option. */
    Map<String, Optional<Path>> files() {
        return Map.of(
                "--cluster-certificate",
                certificate,
                "--cluster-key",
                key,
                "--cluster-ca",
                authority);
    }

    /** Refuses the options of a cluster if {@code --cluster} is not given. */
    void requireNone() {
        PartnerOption.require(spec, "--cluster-listen", listen.isPresent(), "--cluster NAME", name);
        PartnerOption.require(spec, "--seed", !seeds.isEmpty(), "--cluster NAME", name);
        PartnerOption.require(spec, WATCH, watches, "--cluster NAME", name);
        PartnerOption.require(spec, SLEEP_AFTER, sleepAfter.isPresent(), "--cluster NAME", name);
        files().forEach(
                        (option, file) ->
                                PartnerOption.require(
                                        spec, option, file.isPresent(), "--cluster NAME", name));
    }

    private void requireSleepAfter() {
        double seconds = sleepAfter.orElse(MIN_SLEEP_AFTER);
        if (!(seconds >= MIN_SLEEP_AFTER && seconds <= MAX_SLEEP_AFTER)) {
            throw new ParameterException(
                    spec.commandLine(),
                    SLEEP_AFTER
                            + " is "
                            + Rounded.of(seconds)
                            + ", expected "
                            + (long) MIN_SLEEP_AFTER
                            + " to "
                            + (long) MAX_SLEEP_AFTER
                            + " s");
        }
    }

    private NodeAddress parse(String option, String text) {
        try {
            return NodeAddress.parse(text);
        } catch (IllegalArgumentException wrong) {
            throw new ParameterException(spec.commandLine(), option + ": " + wrong.getMessage());
        }
    }

    private Optional<NodeTls.Files> tls() throws IOException {
        List<Optional<Path>> given = List.of(certificate, key, authority);
        if (given.stream().allMatch(Optional::isEmpty)) {
            return Optional.empty();
        }
        if (given.stream().anyMatch(Optional::isEmpty)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--cluster-certificate, --cluster-key and --cluster-ca belong together; found"
                            + " only some of them");
        }
        NodeTls.Files files = new NodeTls.Files(certificate.get(), key.get(), authority.get());
        files.context(); // this call refuses unusable files
        return Optional.of(files);
    }

    private void requireReachable(NodeAddress address, boolean hasTls) throws BindException {
        boolean isLoopback;
        try {
            isLoopback = address.isLoopback();
            if (address.isWildcard()) {
                throw new ParameterException(
                        spec.commandLine(),
                        "--cluster-listen "
                                + address
                                + " stands for all addresses of this machine; name the one at"
                                + " which the other nodes reach it");
            }
        } catch (UnknownHostException unknown) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--cluster-listen "
                            + address
                            + ": there is no such address; expected an address of this machine");
        }
        if (!isLoopback && !hasTls) {
            throw new BindException(
                    "--cluster-listen "
                            + address
                            + ": other machines reach it, so nodes take TLS there; add"
                            + " --cluster-certificate node.crt --cluster-key node.key --cluster-ca"
                            + " ca.crt (docs/cluster.md shows how to make them), or name a loopback"
                            + " address such as 127.0.0.1:2551");
        }
    }
}
