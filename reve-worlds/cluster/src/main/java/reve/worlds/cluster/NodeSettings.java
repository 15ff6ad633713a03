// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import reve.worlds.journal.PostgresUrl;

import java.net.UnknownHostException;
import java.time.Duration;
import java.util.List;
import java.util.Optional;

/**
 * The settings of a node of a cluster.
 *
 * @param cluster name of the cluster, the same for all nodes
 * @param listen address at which the other nodes reach this node; port 0 selects a free port
 * @param seeds nodes through which the node joins; without seeds, the node begins a new cluster
 * @param store text of the database's URL, with its settings
 * @param tls certificate and key of the node; without them, only programs of this machine may reach
 *     the node
 * @param sleepAfter time without clients after which a world sleeps; empty if worlds never sleep
 * @param isWatching whether the node runs no worlds, but shows copies of worlds to observers
 */
public record NodeSettings(
        String cluster,
        NodeAddress listen,
        List<NodeAddress> seeds,
        String store,
        Optional<NodeTls.Files> tls,
        Optional<Duration> sleepAfter,
        boolean isWatching) {
    /** Form of the name of a cluster. */
    public static final String NAME = "[A-Za-z0-9][A-Za-z0-9-]{0,63}";

    /**
     * Copies the list of seeds.
     *
     * @throws IllegalArgumentException if the name or the URL has another form, or other machines
     *     reach the node without TLS
     */
    public NodeSettings {
        if (!cluster.matches(NAME)) {
            throw new IllegalArgumentException(
                    "the cluster is called '"
                            + cluster
                            + "', expected 1 to 64 of A-Z a-z 0-9 - that begin with a letter or a"
                            + " digit");
        }
        if (PostgresUrl.find(store).isEmpty()) {
            throw new IllegalArgumentException(
                    "the store of a cluster is " + store + ", expected the URL of a database");
        }
        if (tls.isEmpty() && !isLoopback(listen)) {
            throw new IllegalArgumentException(
                    "other machines reach " + listen + ", so nodes take TLS there");
        }
        seeds = List.copyOf(seeds);
    }

    private static boolean isLoopback(NodeAddress address) {
        try {
            return address.isLoopback();
        } catch (UnknownHostException unknown) {
            return false;
        }
    }

    /** Returns the database. */
    public PostgresUrl database() {
        return PostgresUrl.find(store).orElseThrow();
    }
}
