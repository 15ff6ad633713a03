// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.file.WorldPack;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.concurrent.locks.LockSupport;
import java.util.stream.Collectors;

/**
 * The command {@code cluster add-world}: adds worlds to the database of a cluster, and waits until
 * nodes run them, unless they shall sleep.
 */
@Command(
        name = "add-world",
        description =
                "Adds worlds to the database of a cluster, with all files that they need. The"
                        + " cluster runs each on the node with the fewest worlds.")
final class ClusterAddCommand implements Callable<Integer> {
    /** Interval between two looks at the database [ns]. */
    private static final long LOOK_NANOSECONDS = 250_000_000L;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "WORLD",
            arity = "1..*",
            description = "World files, folders that contain a world.yaml, or packs (reve pack).")
    private List<Path> paths = new ArrayList<>();

    @Option(
            names = "--store",
            required = true,
            paramLabel = "URL",
            description = "Database of the cluster: postgresql://USER@HOST:PORT/DATABASE.")
    private StoreArgument store = new StoreArgument("", Optional.empty(), Optional.empty());

    @Option(
            names = "--laws",
            paramLabel = "DIR",
            description = "Folder of laws that the worlds name; the database gets copies of them.")
    private Optional<Path> laws = Optional.empty();

    @Option(
            names = "--asleep",
            description =
                    "Let the worlds sleep until clients ask for them. The command then waits for no"
                            + " node.")
    private boolean asleep;

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Mixin private ClusterCommand.Wait wait = new ClusterCommand.Wait();

    @Override
    public Integer call() throws Exception {
        plugins.use();
        wait.require(spec);
        PostgresUrl url =
                store.url()
                        .orElseThrow(
                                () ->
                                        new ParameterException(
                                                spec.commandLine(),
                                                "--store is "
                                                        + store.given()
                                                        + ", expected the URL of the cluster's"
                                                        + " database: postgresql://USER@HOST:PORT"
                                                        + "/DATABASE"));
        Map<String, WorldArgument> worlds = read();
        List<Map<String, Object>> results = new ArrayList<>();
        try (PostgresCatalog catalog = new PostgresCatalog(url)) {
            catalog.prepare();
            List<String> taken = add(catalog, worlds);
            worlds.keySet().stream()
                    .filter(name -> !taken.contains(name))
                    .forEach(name -> results.add(new LinkedHashMap<>(Map.of("world", name))));
            if (asleep) {
                results.forEach(result -> result.put("asleep", true));
            } else if (wait.seconds() > 0) {
                await(catalog, url, results);
            }
            print(url, results);
            requireNew(catalog, url, worlds, taken);
        }
        return ExitCode.OK;
    }

    /** Reads all worlds before any is added. */
    private Map<String, WorldArgument> read() throws Exception {
        Map<String, WorldArgument> worlds = new LinkedHashMap<>();
        for (Path path : paths) {
            WorldArgument world = new WorldArgument(path);
            String name = world.load(spec.commandLine().getErr()).name();
            if (worlds.put(name, world) != null) {
                throw new ParameterException(
                        spec.commandLine(),
                        "two worlds are called "
                                + name
                                + ", expected different names: agents tell them apart by these");
            }
        }
        return worlds;
    }

    /** Adds worlds, and returns the names that the database has already. */
    private List<String> add(PostgresCatalog catalog, Map<String, WorldArgument> worlds)
            throws Exception {
        List<String> taken = new ArrayList<>();
        for (Map.Entry<String, WorldArgument> each : worlds.entrySet()) {
            WorldArgument world = each.getValue();
            Path pack = Files.createTempFile("reve-", WorldPack.ENDING);
            try {
                if (world.isPack()) {
                    Files.copy(world.shown(), pack, StandardCopyOption.REPLACE_EXISTING);
                } else {
                    WorldPack.write(pack, PackedFiles.of(spec, world, laws).files());
                }
                if (!catalog.add(each.getKey(), pack, asleep)) {
                    taken.add(each.getKey());
                }
            } finally {
                Files.deleteIfExists(pack);
            }
        }
        return taken;
    }

    private static void requireNew(
            PostgresCatalog catalog,
            PostgresUrl url,
            Map<String, WorldArgument> worlds,
            List<String> taken)
            throws IOException {
        if (taken.isEmpty()) {
            return;
        }
        String names =
                catalog.worlds().stream()
                        .map(PostgresStore.World::name)
                        .collect(Collectors.joining(", "));
        throw new IOException(
                url
                        + (taken.size() == 1
                                ? " has a world '"
                                        + taken.getFirst()
                                        + "' already, which was not changed"
                                : " has the worlds "
                                        + String.join(", ", taken)
                                        + " already, which were not changed")
                        + ". Its worlds are "
                        + names
                        + "; give the world in "
                        + worlds.get(taken.getFirst()).shown()
                        + " another name");
    }

    /** Waits until servers run the worlds, and adds their places to the results. */
    private void await(PostgresCatalog catalog, PostgresUrl url, List<Map<String, Object>> results)
            throws IOException {
        long end = System.nanoTime() + (long) (wait.seconds() * 1e9);
        while (true) {
            Map<String, PostgresStore.World> running = new HashMap<>();
            catalog.worlds().stream()
                    .filter(each -> !each.agents().isEmpty())
                    .forEach(each -> running.put(each.name(), each));
            for (Map<String, Object> result : results) {
                PostgresStore.World found = running.get((String) result.get("world"));
                if (found != null) {
                    result.putIfAbsent("agents", found.agents());
                    result.putIfAbsent("epoch", found.epoch());
                    result.putIfAbsent("frame", found.frame());
                }
            }
            List<Object> missing =
                    results.stream()
                            .filter(result -> !result.containsKey("agents"))
                            .map(result -> result.get("world"))
                            .toList();
            if (missing.isEmpty()) {
                return;
            }
            if (System.nanoTime() - end >= 0) {
                throw new IOException(
                        "the world "
                                + missing.getFirst()
                                + " is in "
                                + url
                                + ", but no node runs it after "
                                + wait.seconds()
                                + " s. See the messages of the nodes, or start one: serve --cluster"
                                + " NAME --store "
                                + url);
            }
            LockSupport.parkNanos(LOOK_NANOSECONDS);
        }
    }

    private void print(PostgresUrl url, List<Map<String, Object>> results) {
        if (results.isEmpty()) {
            return;
        }
        if (wait.isJson()) {
            Json.print(spec, paths.size() == 1 ? results.getFirst() : Map.of("worlds", results));
            return;
        }
        for (Map<String, Object> result : results) {
            spec.commandLine()
                    .getOut()
                    .println(
                            "world "
                                    + result.get("world")
                                    + (result.containsKey("agents")
                                            ? ": runs, agents at " + result.get("agents")
                                            : asleep
                                                    ? ": added to "
                                                            + url
                                                            + ", sleeps until a client asks for it"
                                                    : ": added to " + url));
        }
        spec.commandLine().getOut().flush();
    }
}
