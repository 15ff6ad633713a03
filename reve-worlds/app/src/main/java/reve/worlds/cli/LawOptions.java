// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;

import reve.pe.adapter.LawFolder;
import reve.pe.hosted.Hosts;
import reve.worlds.Product;
import reve.worlds.server.EnginePlace;
import reve.worlds.server.LawPath;
import reve.worlds.server.Sandboxed;

import java.lang.management.ManagementFactory;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Locale;
import java.util.Optional;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.ConcurrentLinkedQueue;

/** The options that name the folder of laws and permit native code. */
final class LawOptions {
    /** The processes for engines that the commands in this JVM have started. */
    private static final Queue<Hosts> STARTED = new ConcurrentLinkedQueue<>();

    private static final Logger LOG = LoggerFactory.getLogger("laws");

    /**
     * Deadline of a frame for commands without clients. It is long, because no client waits for the
     * frames.
     */
    private static final Duration PATIENT = Duration.ofSeconds(10);

    private static final long MAX_DEADLINE_MS = 3_600_000;
    private static final long MIB = 1 << 20;

    @Option(
            names = "--laws",
            paramLabel = "DIR",
            description =
                    "Folder to search for the laws that a world names, besides the shipped ones."
                            + " serve watches it: it loads new libraries and unloads removed ones.")
    private Optional<Path> folder = Optional.empty();

    @Option(
            names = "--trust",
            description =
                    "Open native code that comes with the world, the store or the "
                            + "recording. The code runs with all of your rights.")
    private boolean trust;

    @Option(
            names = "--untrusted",
            paramLabel = "DIR",
            description =
                    "Folder of laws that you do not trust: each native library of it runs apart, in a"
                            + " sandbox without files, network and other processes. It is searched"
                            + " after --laws, and serve watches it in the same way.")
    private Optional<Path> untrusted = Optional.empty();

    @Option(
            names = "--apart",
            description =
                    "Run native laws that come with the world, the store or the recording in a"
                            + " sandbox each, instead of refusing them.")
    private boolean apart;

    @Option(
            names = "--weak-sandbox",
            description =
                    "Permit --untrusted and --apart although this machine lacks a layer of the"
                            + " sandbox (./reve doctor lists the layers).")
    private boolean weakly;

    @Option(
            names = "--python",
            paramLabel = "DIR",
            description =
                    "Virtual environment whose packages laws in Python may import (default: the"
                            + " packages of the system).")
    private Optional<Path> python = Optional.empty();

    @Option(
            names = "--engine",
            paramLabel = "PLACE",
            defaultValue = "hosted",
            description =
                    "Where laws run. hosted: in a process of their own, so that a law that crashes"
                            + " or hangs costs one repeated frame. in-process: in this process"
                            + " (default: ${DEFAULT-VALUE}).")
    private Place place = Place.HOSTED;

    @Option(
            names = "--law-deadline",
            paramLabel = "MS",
            description =
                    "Longest time that the laws may take for a frame before the one that runs is"
                            + " quarantined [ms], with --engine hosted (default: 50 for serve,"
                            + " 10000 for other commands).")
    private Optional<Long> deadline = Optional.empty();

    @Option(
            names = "--law-memory",
            paramLabel = "MIB",
            description =
                    "Most memory that the laws of a world may allocate [MiB], with --engine hosted;"
                            + " 0: no limit (default: half of the machine's memory).")
    private Optional<Long> memory = Optional.empty();

    /** The values of the option --engine. They state where the engine runs. */
    private enum Place {
        HOSTED,
        IN_PROCESS;

        @Override
        public String toString() {
            return name().toLowerCase(Locale.ROOT).replace('_', '-');
        }
    }

    /** Returns whether native code and programs that come with a world may run. */
    boolean isTrusted() {
        return trust;
    }

    /** Returns the operator's folder of laws. */
    Optional<Path> folder() {
        return folder;
    }

    /**
     * Returns the folders in which a command searches for laws. Folders that come with a world are
     * not included.
     *
     * @throws ParameterException if {@code --laws} or {@code --untrusted} names no folder, or a
     *     world-writable one, or if the machine lacks a layer of the sandbox
     */
    LawPath path(CommandSpec spec) {
        return path(spec, PATIENT, 0);
    }

    /**
     * Returns the law path (folders with laws) for a command.
     *
     * @param usual usual deadline of a frame, which applies without {@code --law-deadline}
     * @param ready number of worlds that may keep a second process of the engine with their laws
     */
    LawPath path(CommandSpec spec, Duration usual, int ready) {
        require(spec, "--laws", folder);
        require(spec, "--untrusted", untrusted);
        return new LawPath(
                Product.nativeFolder().resolve("laws"),
                folder,
                Optional.empty(),
                trust,
                enginePlace(spec, usual, ready),
                false,
                Set.of(),
                sandboxed(spec));
    }

    private Sandboxed sandboxed(CommandSpec spec) {
        Sandboxed sandboxed =
                new Sandboxed(untrusted.map(Path::toAbsolutePath), apart && !trust, weakly);
        if (!sandboxed.isUsed()) {
            return sandboxed;
        }
        if (place == Place.IN_PROCESS) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--untrusted and --apart need a separate process for the engine: remove"
                            + " --engine in-process");
        }
        List<String> missing = SandboxLayers.missing();
        String text = "this machine lacks layers of the sandbox: " + String.join(", ", missing);
        if (!missing.isEmpty() && !weakly) {
            throw new ParameterException(
                    spec.commandLine(),
                    text
                            + "; laws of others could do harm. Provide the layers, or accept the"
                            + " weaker protection with --weak-sandbox");
        }
        if (!missing.isEmpty()) {
            LOG.warn("--weak-sandbox: {}", text);
        }
        return sandboxed;
    }

    /**
     * Returns a law path that only finds laws by their names, so that their files can be copied. It
     * does not open laws.
     */
    static LawPath named(CommandSpec spec, Optional<Path> folder) {
        require(spec, "--laws", folder);
        return new LawPath(Product.nativeFolder().resolve("laws"), folder, Optional.empty(), false);
    }

    private static void require(CommandSpec spec, String option, Optional<Path> folder) {
        try {
            folder.ifPresent(LawFolder::require);
        } catch (IllegalArgumentException unfit) {
            throw new ParameterException(spec.commandLine(), option + ": " + unfit.getMessage());
        }
    }

    private void requirePython(CommandSpec spec) {
        if (python.isEmpty()) {
            return;
        }
        String folder = "--python: " + python.get();
        if (!Files.isRegularFile(python.get().resolve("pyvenv.cfg"))) {
            throw new ParameterException(
                    spec.commandLine(),
                    folder
                            + " is no virtual environment, expected a folder with the file"
                            + " pyvenv.cfg: make one with /usr/bin/python3 -m venv "
                            + python.get());
        }
        if (place == Place.IN_PROCESS) {
            throw new ParameterException(
                    spec.commandLine(),
                    folder
                            + ": laws in Python run only in the engine's own process: remove"
                            + " --engine in-process");
        }
    }

    private EnginePlace enginePlace(CommandSpec spec, Duration usual, int ready) {
        requirePython(spec);
        if (place == Place.IN_PROCESS) {
            return EnginePlace.IN_PROCESS;
        }
        long millis = deadline.orElseGet(usual::toMillis);
        if (millis < 1 || millis > MAX_DEADLINE_MS) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--law-deadline is " + millis + ", expected 1 to " + MAX_DEADLINE_MS + " ms");
        }
        if (memory.orElse(0L) < 0) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--law-memory is " + memory.orElseThrow() + ", expected 0 or more MiB");
        }
        long bytes = memory.map(mib -> mib * MIB).orElseGet(LawOptions::halfOfMemory);
        Hosts hosts = new Hosts(Product.nativeFolder().resolve("vesper-host"), bytes, python);
        hosts.keepReady(ready);
        hosts.refill(); // the first process starts while the world file is read
        STARTED.add(hosts);
        return EnginePlace.hosted(hosts, Duration.ofMillis(millis));
    }

    /**
     * Ends the processes that wait for an engine. Called at the end of a command. They would
     * otherwise run until this JVM ends, and in tests one JVM runs several commands.
     */
    static void endWaiting() {
        for (Hosts hosts = STARTED.poll(); hosts != null; hosts = STARTED.poll()) {
            hosts.close();
        }
    }

    private static long halfOfMemory() {
        return ManagementFactory.getOperatingSystemMXBean()
                        instanceof com.sun.management.OperatingSystemMXBean system
                ? system.getTotalMemorySize() / 2
                : 0;
    }
}
