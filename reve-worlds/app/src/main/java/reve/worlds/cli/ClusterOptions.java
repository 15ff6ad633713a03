// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.worlds.cluster.NodeAddress;
import reve.worlds.cluster.NodeSettings;

import java.net.BindException;
import java.net.UnknownHostException;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/** The options of a server that is a node of a cluster. */
final class ClusterOptions {
    private static final String STORE = "--store postgresql://USER@HOST:PORT/DATABASE";

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

    /** Returns whether the server is a node of a cluster. */
    boolean isGiven() {
        return name.isPresent();
    }

    /**
     * Returns the settings of the node.
     *
     * @param store the store of the worlds, if one was given
     * @throws ParameterException if the options contradict each other
     * @throws BindException if other machines can reach the address
     */
    NodeSettings settings(Optional<StoreArgument> store) throws BindException {
        if (store.flatMap(StoreArgument::url).isEmpty()) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--cluster takes "
                            + STORE
                            + "; found "
                            + store.map(named -> "--store " + named.given()).orElse("no --store"));
        }
        NodeAddress address = parse("--cluster-listen", listen.orElse("127.0.0.1:0"));
        List<NodeAddress> known = seeds.stream().map(seed -> parse("--seed", seed)).toList();
        requireLoopback(address);
        try {
            return new NodeSettings(name.orElseThrow(), address, known, store.get().given());
        } catch (IllegalArgumentException wrong) {
            throw new ParameterException(spec.commandLine(), wrong.getMessage());
        }
    }

    /** Prints that other programs of this machine reach the node. */
    void warn(NodeSettings settings) {
        spec.commandLine()
                .getErr()
                .println(
                        "reve: the nodes of the cluster "
                                + settings.cluster()
                                + " talk without encryption: each user of this machine can join"
                                + " it. Other machines cannot reach it");
        spec.commandLine().getErr().flush();
    }

    /** Refuses the options of a cluster without {@code --cluster}. */
    void requireNone() {
        PartnerOption.require(spec, "--cluster-listen", listen.isPresent(), "--cluster NAME", name);
        PartnerOption.require(spec, "--seed", !seeds.isEmpty(), "--cluster NAME", name);
    }

    private NodeAddress parse(String option, String text) {
        try {
            return NodeAddress.parse(text);
        } catch (IllegalArgumentException wrong) {
            throw new ParameterException(spec.commandLine(), option + ": " + wrong.getMessage());
        }
    }

    private void requireLoopback(NodeAddress address) throws BindException {
        boolean isLoopback;
        try {
            isLoopback = address.isLoopback();
        } catch (UnknownHostException unknown) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--cluster-listen "
                            + address
                            + ": there is no such address; expected an address of this machine");
        }
        if (!isLoopback) {
            throw new BindException(
                    "--cluster-listen "
                            + address
                            + ": other machines reach it, and the messages of nodes are not"
                            + " encrypted; expected a loopback address such as 127.0.0.1:2551");
        }
    }
}
