// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.world.ActionRefused;

import java.util.Map;

/**
 * The operations of operators on the cluster of a server. The results are maps with values of type
 * String, Boolean or Number, or with lists and maps of such values. For any thread.
 */
public interface ClusterPort {
    /** Lets the cluster choose the node of a world. */
    String ANY = "any";

    /** Returns the nodes and worlds of the cluster. Returns at once. */
    Map<String, Object> state();

    /**
     * Orders that a world runs on a node from now on. Returns when the order is stored, before the
     * world moves. May block.
     *
     * @param node address of a node, or {@link #ANY}
     * @return the order, with the present node of the world
     * @throws ActionRefused with a code and a reason if there is no such world, or the node can run
     *     no worlds; nothing is then changed
     */
    Map<String, Object> move(String world, String node) throws ActionRefused;

    /**
     * Orders that a node runs no worlds, or may run worlds again. Returns when the order is stored,
     * before worlds move. May block.
     *
     * @return the order, with the worlds that the node has
     * @throws ActionRefused with a code and a reason if there is no such node, or no other node can
     *     run its worlds; nothing is then changed
     */
    Map<String, Object> drain(String node, boolean isDrained) throws ActionRefused;

    /**
     * Adds a world to the cluster. Returns when the world is stored, before a node runs it. May
     * block.
     *
     * @param text a world file that refers to no other files
     * @param isAsleep whether the world makes its first frame only when a client asks for it
     * @return the name of the world, and the warnings about the file
     * @throws ActionRefused with a code and a reason if the text is no such world file, or the
     *     cluster has a world of this name; nothing is then changed
     */
    Map<String, Object> add(String text, boolean isAsleep) throws ActionRefused;
}
