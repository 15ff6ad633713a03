// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import reve.worlds.Product;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.io.PrintStream;
import java.lang.management.ManagementFactory;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/**
 * The demonstration. A headless server runs {@code worlds/spring-orbit}. A Python agent and a Java
 * agent connect over TCP. A law library is added to the laws folder and removed while the world
 * runs. Pictures show the world without and with the law. Each of the three programs is a separate
 * process.
 */
public final class Demo {
    private static final String LAW = "gravity_field";

    /** World times of the two pictures [s]. The law is added between them. */
    private static final String PICTURES_AT = "2,5";

    /**
     * World time after which the server ends [s]. The agents stay in the world for the same time.
     */
    private static final String SERVER_SECONDS = "60";

    private static final String AGENT_SECONDS = "5";
    private static final long PATIENCE_SECONDS = 60;

    private final Path root;
    private final Path folder;
    private final PrintStream progress;

    /**
     * @param root folder of the checkout
     * @param folder the folder for pictures and log files; it is created if it is missing
     * @param progress receives a line for each stage
     */
    public Demo(Path root, Path folder, PrintStream progress) {
        this.root = root;
        this.folder = folder.toAbsolutePath().normalize();
        this.progress = progress;
    }

    /** Runs the demonstration, which takes about ten seconds, and returns its report. */
    public DemoReport run() throws IOException, InterruptedException {
        Path laws = Files.createDirectories(folder.resolve("laws"));
        Path library = Product.nativeFolder().resolve("laws/libvesper_law_" + LAW + ".so");
        Path dropped = laws.resolve(library.getFileName());
        Files.deleteIfExists(dropped);
        try (JsonProcess server = startServer(laws)) {
            String port = server.await("ready", line -> true).get("agentPort").asString();
            progress.println(
                    "server ready on port " + port + "; starting a Python and a Java agent");
            try (JsonProcess curious = startPythonAgent(port);
                    JsonProcess painter = startJavaAgent(port)) {
                JsonNode before = server.await("picture", line -> true);
                progress.println(
                        "first picture taken; dropping " + library.getFileName() + " into " + laws);
                Files.copy(library, dropped);
                JsonNode loaded = server.await("law-loaded", Demo::isDroppedLaw);
                progress.println(
                        "the law acts since frame "
                                + loaded.get("frame")
                                + "; waiting for the second picture");
                JsonNode after = server.await("picture", line -> !line.equals(before));
                Files.delete(dropped);
                JsonNode unloaded = server.await("law-unloaded", Demo::isDroppedLaw);
                progress.println("law taken out again at frame " + unloaded.get("frame"));
                JsonNode curiousSummary = curious.awaitEnd(PATIENCE_SECONDS);
                JsonNode painterSummary = painter.awaitEnd(PATIENCE_SECONDS);
                server.interrupt();
                return new DemoReport(
                        server.awaitEnd(PATIENCE_SECONDS),
                        loaded,
                        unloaded,
                        before,
                        after,
                        curiousSummary,
                        painterSummary);
            }
        }
    }

    private static boolean isDroppedLaw(JsonNode line) {
        return line.path("library").asString("").equals(LAW);
    }

    private JsonProcess startServer(Path laws) throws IOException {
        List<String> command =
                java(
                        "reve.worlds.cli.Main",
                        "serve",
                        root.resolve("worlds/spring-orbit").toString(),
                        "--port",
                        "0",
                        "--laws",
                        laws.toString(),
                        "--pictures",
                        folder.toString(),
                        "--picture-at",
                        PICTURES_AT,
                        "--seconds",
                        SERVER_SECONDS,
                        "--json");
        return new JsonProcess("server", command, Map.of(), folder.resolve("server.log"));
    }

    private JsonProcess startPythonAgent(String port) throws IOException {
        Path python = root.resolve("agents/python");
        List<String> command =
                List.of(
                        "python3",
                        python.resolve("examples/curious.py").toString(),
                        "--port",
                        port,
                        "--name",
                        "curious",
                        "--seconds",
                        AGENT_SECONDS);
        return new JsonProcess(
                "Python agent",
                command,
                Map.of("PYTHONPATH", python.toString()),
                folder.resolve("curious.log"));
    }

    private JsonProcess startJavaAgent(String port) throws IOException {
        List<String> command =
                java(
                        "reve.agent.examples.Painter",
                        "--port",
                        port,
                        "--name",
                        "painter",
                        "--seconds",
                        AGENT_SECONDS);
        return new JsonProcess("Java agent", command, Map.of(), folder.resolve("painter.log"));
    }

    /** Returns a Java command with the options and the class path of this process. */
    static List<String> java(String... arguments) {
        List<String> command = new ArrayList<>();
        command.add(Path.of(System.getProperty("java.home"), "bin", "java").toString());
        command.addAll(ManagementFactory.getRuntimeMXBean().getInputArguments());
        command.addAll(List.of("-cp", System.getProperty("java.class.path")));
        command.addAll(List.of(arguments));
        return command;
    }
}
