// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.DisconnectedException;
import reve.agent.Join;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.PrintStream;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;

/**
 * The demonstration of a cluster. Three servers on loopback share the worlds of a database, which
 * the demonstration starts. The server that runs the world {@code spring-orbit} is killed. Another
 * one continues the world. Pictures show the world before and after. Each server is a process of
 * its own; all processes end with the demonstration.
 */
public final class ClusterDemo {
    private static final int NODES = 3;
    private static final String WORLD = "spring-orbit";
    private static final double FRAMES_PER_SECOND = 60;

    /** Frame of the first picture. */
    private static final long FIRST_FRAMES = 60;

    /** Number of frames between the kill and the second picture. */
    private static final long MORE_FRAMES = 60;

    private static final Duration PATIENCE = Duration.ofSeconds(60);
    private static final Duration PAUSE = Duration.ofMillis(100);

    /** Code of a server that does not know the world. */
    private static final String UNKNOWN = "no-such-world";

    private final Path root;
    private final Path folder;
    private final Optional<Path> programs;
    private final PrintStream progress;
    private final List<AutoCloseable> started = new ArrayList<>();

    /** A server of the cluster. */
    private record Node(JsonProcess process, String address, int agentPort) {}

    /**
     * @param root folder of the checkout
     * @param folder an existing folder for pictures and log files
     * @param programs folder with the programs of PostgreSQL; if empty, the usual ones are searched
     * @param progress receives a line for each stage
     */
    public ClusterDemo(Path root, Path folder, Optional<Path> programs, PrintStream progress) {
        this.root = root;
        this.folder = folder.toAbsolutePath().normalize();
        this.programs = programs;
        this.progress = progress;
    }

    /**
     * Runs the demonstration, which takes about half a minute, and returns its report.
     *
     * @throws IOException if PostgreSQL is not installed or does not start
     * @throws IllegalStateException if a server fails
     */
    public ClusterDemoReport run() throws IOException, InterruptedException {
        Thread atExit = new Thread(this::end, "end of the demonstration");
        Runtime.getRuntime().addShutdownHook(atExit);
        try {
            return demonstrate();
        } finally {
            end();
            try {
                Runtime.getRuntime().removeShutdownHook(atExit);
            } catch (IllegalStateException exiting) {
                // The process ends, and the hook runs.
            }
        }
    }

    private ClusterDemoReport demonstrate() throws IOException, InterruptedException {
        progress.println("starting a database and " + NODES + " servers");
        DemoDatabase database = keep(new DemoDatabase(programs));
        Map<String, Node> nodes = startNodes(database);
        Node first = nodes.values().iterator().next();
        Node owner;
        long seen;
        ClusterDemoReport.Picture before;
        try (AgentClient client = join(first)) {
            owner = nodes.get(ownerOf(client));
            while (client.perceive().frame() < FIRST_FRAMES) {
                Thread.onSpinWait(); // each perception waits for a frame
            }
            before = picture(client, owner);
            progress.println(
                    "the server "
                            + owner.address()
                            + " runs the world "
                            + WORLD
                            + "; first picture taken; killing the server (kill -9)");
            seen = client.perceive().frame();
        }
        owner.process().kill();
        long killed = System.nanoTime();
        Node survivor =
                nodes.values().stream().filter(node -> node != owner).findFirst().orElseThrow();
        try (AgentClient client = join(survivor)) {
            double seconds = (System.nanoTime() - killed) * 1e-9;
            Node heir = nodes.get(ownerOf(client));
            JsonNode ready =
                    heir.process()
                            .await("ready", event -> event.path("world").asString().equals(WORLD));
            long resumed = ready.path("frame").asLong();
            progress.println(
                    "the server "
                            + heir.address()
                            + " continues the world at frame "
                            + resumed
                            + "; comparing it with a world that was never disturbed");
            Process undisturbed = startUndisturbed(resumed);
            while (client.perceive().frame() < resumed + MORE_FRAMES) {
                Thread.onSpinWait();
            }
            ClusterDemoReport.Picture after = picture(client, heir);
            return new ClusterDemoReport(
                    WORLD,
                    List.copyOf(nodes.keySet()),
                    owner.address(),
                    heir.address(),
                    seen,
                    resumed,
                    ready.path("epoch").asLong(),
                    seconds,
                    ready.path("stateHash").asString(),
                    stateHash(undisturbed),
                    before,
                    after);
        }
    }

    /** Starts the servers, which join through the first one. The last one adds the world. */
    private Map<String, Node> startNodes(DemoDatabase database)
            throws IOException, InterruptedException {
        Map<String, Node> nodes = new TreeMap<>();
        List<JsonProcess> processes = new ArrayList<>();
        Node first = node(startNode(database, 1, List.of()));
        nodes.put(first.address(), first);
        for (int i = 2; i <= NODES; i++) {
            List<String> more = new ArrayList<>(List.of("--seed", first.address()));
            if (i == NODES) {
                more.add(root.resolve("worlds").resolve(WORLD).toString());
            }
            processes.add(startNode(database, i, more));
        }
        for (JsonProcess process : processes) {
            Node other = node(process);
            nodes.put(other.address(), other);
            first.process()
                    .await(
                            "cluster",
                            event ->
                                    event.path("status").asString().equals("up")
                                            && event.path("node")
                                                    .asString()
                                                    .equals(other.address()));
        }
        return nodes;
    }

    private JsonProcess startNode(DemoDatabase database, int number, List<String> more)
            throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "reve.worlds.cli.Main",
                                "serve",
                                "--cluster",
                                "demo",
                                "--store",
                                database.url(),
                                "--port",
                                "0",
                                "--pictures",
                                folder.toString(),
                                "--json"));
        arguments.addAll(more);
        return keep(
                new JsonProcess(
                        "server " + number,
                        Demo.java(arguments.toArray(String[]::new)),
                        database.environment(),
                        folder.resolve("server-" + number + ".log")));
    }

    private static Node node(JsonProcess process) throws InterruptedException {
        JsonNode starts =
                process.await("cluster", event -> event.path("status").asString().equals("starts"));
        return new Node(process, starts.path("node").asString(), starts.path("agentPort").asInt());
    }

    /** Joins the world through a server. Waits until a server of the cluster runs the world. */
    private static AgentClient join(Node node) throws IOException, InterruptedException {
        Join join = Join.as("demo").withRole("control").withWorld(WORLD).withPatience(PATIENCE);
        long end = System.nanoTime() + PATIENCE.toNanos();
        while (true) {
            try {
                return AgentClient.connect("127.0.0.1", node.agentPort(), join);
            } catch (DisconnectedException refused) {
                if (!refused.code().equals(UNKNOWN) || System.nanoTime() - end > 0) {
                    throw refused;
                }
            }
            Thread.sleep(PAUSE); // the server has not read the list of worlds yet
        }
    }

    /** Returns the address of the server that runs the client's world. */
    private static String ownerOf(AgentClient client) throws InterruptedException {
        while (true) {
            ActResult told = client.command("cluster", Map.of());
            for (Object each : (List<?>) ((Map<?, ?>) told.value().orElseThrow()).get("worlds")) {
                Map<?, ?> world = (Map<?, ?>) each;
                if (WORLD.equals(world.get("world")) && world.get("node") instanceof String node) {
                    return node;
                }
            }
            Thread.sleep(PAUSE); // the servers read the list of worlds once a second
        }
    }

    private static ClusterDemoReport.Picture picture(AgentClient client, Node owner)
            throws InterruptedException {
        ActResult taken = client.command("picture", Map.of());
        if (!taken.accepted()) {
            throw new IllegalStateException(
                    "the server "
                            + owner.address()
                            + " takes no picture: "
                            + taken.reason().orElse(""));
        }
        long frame = taken.frame().orElseThrow();
        JsonNode picture =
                owner.process().await("picture", event -> event.path("frame").asLong() == frame);
        return new ClusterDemoReport.Picture(frame, picture.path("file").asString());
    }

    /** Starts a run of the world by itself for this number of frames, as a process. */
    private Process startUndisturbed(long frames) throws IOException {
        Process run =
                new ProcessBuilder(
                                Demo.java(
                                        "reve.worlds.cli.Main",
                                        "run",
                                        root.resolve("worlds").resolve(WORLD).toString(),
                                        "--seconds",
                                        Double.toString(frames / FRAMES_PER_SECOND),
                                        "--json"))
                        .redirectError(folder.resolve("run.log").toFile())
                        .start();
        keep((AutoCloseable) run::destroyForcibly);
        return run;
    }

    /** Waits for the end of a run, and returns the hash of the last state. */
    private String stateHash(Process run) throws IOException, InterruptedException {
        String output = new String(run.getInputStream().readAllBytes());
        if (run.waitFor() != 0) {
            throw new IllegalStateException(
                    "the undisturbed run failed; see " + folder.resolve("run.log"));
        }
        return new JsonMapper().readTree(output).path("stateHash").asString();
    }

    private synchronized <T extends AutoCloseable> T keep(T resource) {
        started.add(resource);
        return resource;
    }

    /** Ends all processes: the servers first, then the database. */
    private synchronized void end() {
        for (AutoCloseable each : started.reversed()) {
            try {
                each.close();
            } catch (Exception failed) {
                progress.println("reve: " + failed.getMessage());
            }
        }
        started.clear();
    }
}
