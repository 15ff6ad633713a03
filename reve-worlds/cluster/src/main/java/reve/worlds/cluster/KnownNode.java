// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.actor.Address;
import org.apache.pekko.cluster.ClusterEvent;
import org.apache.pekko.cluster.Member;

import java.util.HashSet;
import java.util.List;
import java.util.Locale;
import java.util.Set;
import java.util.TreeMap;

/**
 * A node of a cluster, as another node knows it.
 *
 * @param address HOST:PORT at which the other nodes reach it
 * @param agents HOST:PORT at which agents reach it; empty if the node has not announced it
 * @param status status of Pekko, or {@code unreachable}
 * @param isWatching whether the node runs no worlds, but shows copies of worlds to observers
 */
record KnownNode(String address, String agents, String status, boolean isWatching) {
    /** Begins the role of a node that contains its address for agents. */
    static final String AGENTS = "agents=";

    /** Role of a node that runs no worlds, but shows copies of worlds to observers. */
    static final String WATCHES = "watches";

    private static final String UNREACHABLE = "unreachable";

    /** Returns the nodes of a cluster, in the order of their addresses as texts. */
    static List<KnownNode> of(ClusterEvent.CurrentClusterState cluster) {
        Set<Address> unreachable = new HashSet<>();
        cluster.getUnreachable().forEach(member -> unreachable.add(member.address()));
        TreeMap<String, KnownNode> sorted = new TreeMap<>();
        cluster.getMembers()
                .forEach(
                        member -> {
                            String address = textOf(member.address()).toString();
                            String status =
                                    unreachable.contains(member.address())
                                            ? UNREACHABLE
                                            : member.status().toString().toLowerCase(Locale.ROOT);
                            sorted.put(
                                    address,
                                    new KnownNode(
                                            address,
                                            agentsOf(member),
                                            status,
                                            member.getRoles().contains(WATCHES)));
                        });
        return List.copyOf(sorted.values());
    }

    /** Returns whether the other nodes get answers from the node. */
    boolean isReached() {
        return !status.equals(UNREACHABLE);
    }

    /** Returns whether the node is a full member of the cluster. */
    boolean isUp() {
        return status.equals("up");
    }

    /** Returns the address of a node as other nodes name it. */
    static NodeAddress textOf(Address address) {
        return new NodeAddress(address.getHost().orElse(""), address.getPort().orElse(0));
    }

    private static String agentsOf(Member member) {
        for (String role : member.getRoles()) {
            if (role.startsWith(AGENTS)) {
                return role.substring(AGENTS.length());
            }
        }
        return "";
    }
}
