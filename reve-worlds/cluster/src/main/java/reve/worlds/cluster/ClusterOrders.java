// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import reve.core.agent.port.ClusterPort;
import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.file.WorldPack;
import reve.core.world.ActionRefused;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;
import java.util.function.Supplier;
import java.util.stream.Collectors;

/**
 * The orders of operators about worlds and their places. They are stored in the database, so they
 * survive the loss of nodes. The node that places worlds follows them. For any thread.
 */
final class ClusterOrders {
    private final PostgresCatalog catalog;
    private final Supplier<List<KnownNode>> nodes;

    /**
     * @param nodes returns the nodes of the cluster
     */
    ClusterOrders(PostgresCatalog catalog, Supplier<List<KnownNode>> nodes) {
        this.catalog = catalog;
        this.nodes = nodes;
    }

    /** See {@link ClusterPort#move}. */
    Map<String, Object> move(String world, String node) throws ActionRefused {
        List<KnownNode> known = nodes.get();
        return stored(
                () -> {
                    PostgresStore.World moved = requireWorld(world);
                    if (!node.equals(ClusterPort.ANY)) {
                        requireUsable(node, known);
                    }
                    catalog.place(
                            world,
                            node.equals(ClusterPort.ANY) ? Optional.empty() : Optional.of(node));
                    Map<String, Object> order = new LinkedHashMap<>();
                    order.put("world", world);
                    order.put("to", node);
                    known.stream()
                            .filter(each -> isAt(moved, each))
                            .forEach(each -> order.put("from", each.address()));
                    order.put("epoch", moved.epoch());
                    return order;
                });
    }

    /** See {@link ClusterPort#drain}. */
    Map<String, Object> drain(String node, boolean isDrained) throws ActionRefused {
        List<KnownNode> known = nodes.get();
        KnownNode found = requireNode(node, known);
        return stored(
                () -> {
                    if (isDrained) {
                        requireAnother(node, known);
                    }
                    catalog.drain(node, isDrained);
                    Map<String, Object> order = new LinkedHashMap<>();
                    order.put("node", node);
                    order.put("drained", isDrained);
                    order.put(
                            "worlds",
                            catalog.worlds().stream()
                                    .filter(world -> isAt(world, found))
                                    .map(PostgresStore.World::name)
                                    .toList());
                    return order;
                });
    }

    /** See {@link ClusterPort#add}. */
    Map<String, Object> add(String text, boolean isAsleep) throws ActionRefused {
        WorldDescription world = parse(text);
        return stored(
                () -> {
                    if (!add(world.name(), text, isAsleep)) {
                        throw new ActionRefused(
                                "world-exists",
                                "the cluster has a world '"
                                        + world.name()
                                        + "' already, which was not changed; give the new world"
                                        + " another name");
                    }
                    Map<String, Object> added = new LinkedHashMap<>();
                    added.put("world", world.name());
                    added.put("asleep", isAsleep);
                    if (!world.warnings().isEmpty()) {
                        added.put(
                                "warnings",
                                world.warnings().stream().map(Problem::toString).toList());
                    }
                    return added;
                });
    }

    /** Reads the text of a world. Reads one at a time, so that clients do not exhaust the heap. */
    private synchronized WorldDescription parse(String text) throws ActionRefused {
        try {
            return WorldFile.parseMessage(WorldFile.NAME, text.getBytes(StandardCharsets.UTF_8));
        } catch (WorldFileException wrong) {
            throw new ActionRefused("bad-world", String.valueOf(wrong.getMessage()));
        }
    }

    private boolean add(String world, String text, boolean isAsleep) throws IOException {
        Path file = Files.createTempFile("reve-", ".yaml");
        Path pack = Files.createTempFile("reve-", WorldPack.ENDING);
        try {
            Files.writeString(file, text);
            WorldPack.write(pack, new TreeMap<>(Map.of(WorldFile.NAME, file)));
            return catalog.add(world, pack, isAsleep);
        } finally {
            Files.deleteIfExists(file);
            Files.deleteIfExists(pack);
        }
    }

    private static boolean isAt(PostgresStore.World world, KnownNode node) {
        return !world.agents().isEmpty() && world.agents().equals(node.agents());
    }

    private PostgresStore.World requireWorld(String world) throws IOException, ActionRefused {
        List<PostgresStore.World> worlds = catalog.worlds();
        return worlds.stream()
                .filter(each -> each.name().equals(world))
                .findFirst()
                .orElseThrow(
                        () ->
                                new ActionRefused(
                                        "no-such-world",
                                        "the cluster has no world '"
                                                + world
                                                + "', expected one of "
                                                + worlds.stream()
                                                        .map(PostgresStore.World::name)
                                                        .collect(Collectors.joining(", "))));
    }

    private static KnownNode requireNode(String node, List<KnownNode> known) throws ActionRefused {
        return known.stream()
                .filter(each -> each.address().equals(node))
                .findFirst()
                .orElseThrow(
                        () ->
                                new ActionRefused(
                                        "no-such-node",
                                        "the cluster has no node '"
                                                + node
                                                + "', expected one of "
                                                + known.stream()
                                                        .map(KnownNode::address)
                                                        .collect(Collectors.joining(", "))));
    }

    private void requireUsable(String node, List<KnownNode> known)
            throws IOException, ActionRefused {
        KnownNode wanted = requireNode(node, known);
        if (!wanted.isUp()) {
            throw new ActionRefused(
                    "node-not-up",
                    "the node "
                            + node
                            + " is "
                            + wanted.status()
                            + ", expected a node that is up; choose another one");
        }
        if (wanted.isWatching()) {
            throw new ActionRefused(
                    "node-watching",
                    "the node " + node + " only watches and runs no worlds; choose another node");
        }
        if (catalog.places().drained().contains(node)) {
            throw new ActionRefused(
                    "node-drained",
                    "the node "
                            + node
                            + " is drained and runs no worlds; end this with `cluster drain "
                            + node
                            + " --end`, or choose another node");
        }
    }

    private void requireAnother(String node, List<KnownNode> known)
            throws IOException, ActionRefused {
        PostgresCatalog.Places places = catalog.places();
        boolean isLast =
                known.stream()
                        .noneMatch(
                                each ->
                                        each.isUp()
                                                && !each.isWatching()
                                                && !each.address().equals(node)
                                                && !places.drained().contains(each.address()));
        if (isLast) {
            throw new ActionRefused(
                    "last-node",
                    "no other node than "
                            + node
                            + " can run worlds; start another one, or end the drain of one, first");
        }
    }

    /** An order that the database stores. */
    private interface Order {
        Map<String, Object> give() throws IOException, ActionRefused;
    }

    private static Map<String, Object> stored(Order order) throws ActionRefused {
        try {
            return order.give();
        } catch (IOException away) {
            throw new ActionRefused(
                    "not-stored",
                    away.getMessage() + "; the order may not be stored, so give it again",
                    away);
        }
    }
}
