// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.core.agent.port.ClusterPort;
import reve.core.text.Rounded;
import reve.core.text.Visible;

import java.io.IOException;
import java.io.PrintWriter;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.locks.LockSupport;

/** The command {@code cluster}: shows the nodes and worlds of a cluster, and moves worlds. */
@Command(
        name = "cluster",
        subcommands = ClusterAddCommand.class,
        description =
                "Shows the nodes of a cluster, and on which of them each world runs; moves worlds"
                        + " between nodes, and adds worlds.")
public final class ClusterCommand implements Runnable {
    /** Interval between two looks at a world that moves [ns]. */
    private static final long LOOK_NANOSECONDS = 250_000_000L;

    private static final double MAX_TIMEOUT_SECONDS = 86_400;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Override
    public void run() {
        throw new ParameterException(
                spec.commandLine(), "expected status, move, drain or add-world");
    }

    /** The options of a command that waits until worlds have moved. */
    static final class Wait {
        @Option(
                names = "--timeout",
                paramLabel = "SECONDS",
                defaultValue = "60",
                description =
                        "Maximum time to wait until the worlds run elsewhere [s]; 0 does not wait"
                                + " (default: ${DEFAULT-VALUE}).")
        private double seconds;

        @Option(names = "--json", description = "Print the result as one JSON document.")
        private boolean json;

        double seconds() {
            return seconds;
        }

        boolean isJson() {
            return json;
        }

        /** Refuses a time that is not in the permitted range. */
        void require(CommandSpec spec) {
            if (!(seconds >= 0 && seconds <= MAX_TIMEOUT_SECONDS)) {
                throw new ParameterException(
                        spec.commandLine(),
                        "--timeout is "
                                + Rounded.of(seconds)
                                + ", expected 0 to "
                                + (long) MAX_TIMEOUT_SECONDS
                                + " seconds");
            }
        }
    }

    @Command(
            name = "status",
            description =
                    "Lists the nodes and worlds of a cluster, as one of its nodes knows them. Joins"
                            + " no world, so no world wakes.")
    int status(
            @Mixin ServerTarget target,
            @Option(names = "--json", description = "Print the result as one JSON document.")
                    boolean json)
            throws IOException {
        Map<String, Object> state = state(target);
        if (json) {
            Json.print(spec, state);
        } else {
            print(state);
        }
        return ExitCode.OK;
    }

    @Command(
            name = "move",
            description =
                    "Moves a world to a node, where it stays. The world loses no frame. NODE any"
                            + " ends such an order: the cluster then chooses the node.")
    int move(
            @Parameters(paramLabel = "WORLD", description = "Name of the world.") String world,
            @Parameters(
                            paramLabel = "NODE",
                            description =
                                    "HOST:PORT of the node, as cluster status shows it, or any.")
                    String node,
            @Mixin ControlTarget target,
            @Mixin Wait wait)
            throws IOException {
        wait.require(spec);
        Map<String, Object> order =
                order(
                        target,
                        Optional.of(world),
                        "move-world",
                        Map.of("world", world, "node", node));
        if (!node.equals(ClusterPort.ANY) && wait.seconds > 0) {
            Map<?, ?> now =
                    await(
                            target,
                            wait,
                            state -> {
                                Map<?, ?> found = find(state, "worlds", "world", world);
                                return node.equals(found.get("node")) ? found : null;
                            },
                            "the world " + world + " to " + node);
            order.put("epoch", now.get("epoch"));
            order.put("frame", now.get("frame"));
            order.put("agents", now.get("agents"));
        }
        if (wait.json) {
            Json.print(spec, order);
        } else {
            out(
                    "world "
                            + world
                            + (node.equals(ClusterPort.ANY)
                                    ? ": the cluster chooses its node"
                                    : order.containsKey("frame")
                                            ? ": on "
                                                    + node
                                                    + " at frame "
                                                    + text(order, "frame")
                                                    + ", epoch "
                                                    + text(order, "epoch")
                                                    + ", agents at "
                                                    + text(order, "agents")
                                            : ": moves to " + node));
        }
        return ExitCode.OK;
    }

    @Command(
            name = "drain",
            description =
                    "Moves all worlds of a node to other nodes, and gives the node no more worlds."
                            + " The node stays in the cluster until it ends. The command joins the"
                            + " world of --world, or any world that does not sleep.")
    int drain(
            @Parameters(
                            paramLabel = "NODE",
                            description = "HOST:PORT of the node, as cluster status shows it.")
                    String node,
            @Option(names = "--end", description = "Let a drained node run worlds again.")
                    boolean end,
            @Mixin ControlTarget target,
            @Mixin Wait wait)
            throws IOException {
        wait.require(spec);
        Map<String, Object> order =
                order(
                        target,
                        awake(state(target)),
                        "drain-node",
                        Map.of("node", node, "drained", !end));
        List<Object> moved = new ArrayList<>((List<?>) order.get("worlds"));
        if (!end && wait.seconds > 0 && !moved.isEmpty()) {
            Map<?, ?> now =
                    await(
                            target,
                            wait,
                            state -> hasLeft(state, moved, node) ? state : null,
                            "all worlds away from " + node);
            Map<String, Object> places = new LinkedHashMap<>();
            moved.forEach(
                    world ->
                            places.put(
                                    String.valueOf(world),
                                    place(find(now, "worlds", "world", world))));
            order.put("to", places);
        }
        if (wait.json) {
            Json.print(spec, order);
            return ExitCode.OK;
        }
        out(
                "node "
                        + node
                        + (end
                                ? ": may run worlds again"
                                : moved.isEmpty()
                                        ? ": drained, had no worlds"
                                        : wait.seconds > 0 ? ": drained" : ": its worlds move"));
        if (order.get("to") instanceof Map<?, ?> places) {
            places.forEach(
                    (world, place) ->
                            out(
                                    "world "
                                            + world
                                            + (place.equals("asleep") ? ": " : ": on ")
                                            + place));
        }
        return ExitCode.OK;
    }

    private static Map<String, Object> state(ServerTarget target) throws IOException {
        try {
            return value(target.cluster());
        } catch (AgentException refused) {
            throw target.refused(refused);
        }
    }

    /** Returns a world that a node runs; empty if all worlds sleep. */
    private static Optional<String> awake(Map<?, ?> state) {
        return ((List<?>) state.get("worlds"))
                .stream()
                        .map(each -> (Map<?, ?>) each)
                        .filter(world -> world.containsKey("node"))
                        .map(world -> String.valueOf(world.get("world")))
                        .findFirst();
    }

    /**
     * Gives an order to a cluster, and returns the answer.
     *
     * @param world the world that the command joins, unless the user names one
     */
    private static Map<String, Object> order(
            ControlTarget target, Optional<String> world, String type, Map<String, ?> fields)
            throws IOException {
        for (boolean isRepeated = false; ; isRepeated = true) {
            try (AgentClient client = target.connectTo(world)) {
                return value(client.command(type, fields));
            } catch (AgentException refused) {
                if (isRepeated || !refused.code().equals("moved")) {
                    throw target.refused(refused);
                } // the client's world moved before the answer; the order may be given twice
            }
        }
    }

    /** Reads a result from the state of a cluster. */
    private interface Reading {
        /** Returns null if the state does not contain the result yet. */
        @Nullable Map<?, ?> read(Map<?, ?> state);
    }

    /**
     * Reads the state of a cluster until it contains a result.
     *
     * @param goal what the caller waits for, for a message
     */
    private static Map<?, ?> await(ServerTarget target, Wait wait, Reading wanted, String goal)
            throws IOException {
        long end = System.nanoTime() + (long) (wait.seconds * 1e9);
        String last = "no node has answered";
        while (true) {
            try {
                Map<String, Object> state = state(target);
                Map<?, ?> found = wanted.read(state);
                if (found != null) {
                    return found;
                }
                last = places(state);
            } catch (IOException away) {
                last = String.valueOf(away.getMessage());
            }
            if (System.nanoTime() - end >= 0) {
                throw new IOException(
                        "the order to move "
                                + goal
                                + " is stored, but was not done within "
                                + wait.seconds
                                + " s: "
                                + last
                                + ". The cluster goes on with it; see cluster status and the"
                                + " messages of the nodes");
            }
            LockSupport.parkNanos(LOOK_NANOSECONDS);
        }
    }

    private static String places(Map<?, ?> state) {
        List<String> places = new ArrayList<>();
        for (Object each : (List<?>) state.get("worlds")) {
            Map<?, ?> world = (Map<?, ?>) each;
            places.add(
                    text(world, "world")
                            + (world.containsKey("node")
                                    ? " runs on " + text(world, "node")
                                    : " runs on no node"));
        }
        return String.join(", ", places);
    }

    /** Returns whether each of these worlds sleeps, or runs on a node other than {@code node}. */
    private static boolean hasLeft(Map<?, ?> state, List<Object> worlds, String node) {
        return worlds.stream()
                .map(world -> find(state, "worlds", "world", world))
                .allMatch(
                        world ->
                                isAsleep(world)
                                        || world.containsKey("node")
                                                && !node.equals(world.get("node")));
    }

    private static boolean isAsleep(Map<?, ?> world) {
        return Boolean.TRUE.equals(world.get("asleep"));
    }

    /** Returns the node of a world, or {@code asleep}. */
    private static Object place(Map<?, ?> world) {
        return isAsleep(world) ? "asleep" : world.get("node");
    }

    /** Returns the entry of a list whose field has this value; an empty map if there is none. */
    private static Map<?, ?> find(Map<?, ?> state, String list, String field, Object value) {
        for (Object each : (List<?>) state.get(list)) {
            if (each instanceof Map<?, ?> fields && value.equals(fields.get(field))) {
                return fields;
            }
        }
        return Map.of();
    }

    private static Map<String, Object> value(ActResult result) throws IOException {
        if (!result.accepted()) {
            throw new IOException(
                    result.code().orElse("refused") + ": " + result.reason().orElse(""));
        }
        Map<String, Object> fields = new LinkedHashMap<>();
        ((Map<?, ?>) result.value().orElseThrow())
                .forEach((name, value) -> fields.put(String.valueOf(name), value));
        return fields;
    }

    private void out(String line) {
        PrintWriter out = spec.commandLine().getOut();
        out.println(Visible.line(line));
        out.flush();
    }

    private void print(Map<?, ?> state) {
        out("cluster " + text(state, "cluster") + ", as " + text(state, "node") + " knows it");
        for (Object each : (List<?>) state.get("nodes")) {
            Map<?, ?> node = (Map<?, ?>) each;
            out(
                    "node "
                            + text(node, "node")
                            + ": "
                            + text(node, "status")
                            + (Boolean.TRUE.equals(node.get("watching")) ? ", watches" : "")
                            + (Boolean.TRUE.equals(node.get("drained")) ? ", drained" : "")
                            + ", worlds: "
                            + text(node, "worlds")
                            + ", agents at "
                            + text(node, "agents")
                            + (node.containsKey("version")
                                    ? ", REVE " + text(node, "version")
                                    : ""));
        }
        for (Object each : (List<?>) state.get("worlds")) {
            Map<?, ?> world = (Map<?, ?>) each;
            out(
                    "world "
                            + text(world, "world")
                            + ": frame "
                            + text(world, "frame")
                            + ", epoch "
                            + text(world, "epoch")
                            + (world.containsKey("node")
                                    ? ", on " + text(world, "node")
                                    : isAsleep(world) ? ", asleep" : ", on no node")
                            + (world.containsKey("ordered")
                                    ? ", ordered to " + text(world, "ordered")
                                    : ""));
        }
    }

    private static String text(Map<?, ?> fields, String name) {
        return Visible.line(String.valueOf(fields.get(name)));
    }
}
