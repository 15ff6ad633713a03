// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.disk.Reason;
import reve.core.frame.CommandQueue;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Status;
import reve.pe.posix.FolderFiles;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.InvalidPathException;
import java.nio.file.LinkOption;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.attribute.BasicFileAttributes;
import java.nio.file.attribute.PosixFilePermission;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.concurrent.TimeUnit;

/**
 * A watched folder of law libraries. The laws of an added file act from the next frame on. The laws
 * of a removed file are unloaded. The laws of a replaced file are exchanged between two frames.
 * Files that are found ready in the same scan change together. Renamed files keep their laws. A
 * separate thread scans the folder and checks the libraries. The world's thread only activates
 * libraries that passed the check, by commands that name this folder as their origin. Each refusal
 * becomes one "fault" event.
 *
 * <p>Only files whose name ends in ".so", ".law" or ".py" contain libraries. A file is ready as
 * soon as two scans have found the same size and time of change. A file that cannot be loaded may
 * still be incomplete, so it is reported only after further scans have found it unchanged.
 *
 * <p>A file {@code wind.yaml} contains the parameters of the library in {@code wind.law}, {@code
 * wind.py}, {@code wind.so} or {@code libvesper_law_wind.so}. The parameters of the running laws
 * change when this file changes.
 */
public final class LawFolder implements AutoCloseable {
    /** Origin of this folder's commands; it contains a space, so no agent can have this name. */
    public static final String ORIGIN = "laws folder";

    /** Origin of the commands of a folder whose laws run in a sandbox. */
    public static final String UNTRUSTED_ORIGIN = "untrusted laws folder";

    /** Maximum number of active libraries of one folder. */
    public static final int MAX_LIBRARIES = 64;

    /** Interval between two scans of the folder. */
    public static final Duration INTERVAL = Duration.ofMillis(200);

    /** Ending of a file with parameters, after the name of the library. */
    private static final String PARAMETERS_ENDING = ".yaml";

    private static final String PREFIX = "libvesper_law_";
    private static final Logger LOG = LoggerFactory.getLogger(LawFolder.class);
    private static final int LOOKS_UNTIL_STABLE = 2;
    private static final int LOOKS_UNTIL_TOLD = 12;

    private final String origin;
    private final Path folder;
    private final PhysicsEngine engine;
    private final CommandQueue commands;
    private final FolderParameters.Reader parameters;
    private final FolderLaws active;
    private final Map<String, WatchedFile> files = new TreeMap<>();

    /** Libraries in commands that the world has perhaps not executed yet. */
    private final List<Offered> pending = new ArrayList<>();

    /** Files that this scan has found ready; all of them become one change. */
    private final List<Ready> ready = new ArrayList<>();

    private long sequence;
    private @Nullable Thread thread;
    private @Nullable String lastWarning;

    /** The identity of a file's content as far as it is known without reading the file. */
    private record Stamp(@Nullable Object key, long size, long modifiedNanoseconds) {
        static Stamp of(BasicFileAttributes attributes) {
            return new Stamp(
                    attributes.fileKey(),
                    attributes.size(),
                    attributes.lastModifiedTime().to(TimeUnit.NANOSECONDS));
        }
    }

    /** A file that is ready to be passed to the world. */
    private record Ready(WatchedFile file, FolderLaws.Put put) {}

    /** The libraries in a command to the world. */
    private static final class Offered {
        private final List<FolderLaws.Put> puts;

        /** True if the world has executed the command, and has closed or loaded the libraries. */
        volatile boolean isTaken;

        Offered(List<FolderLaws.Put> puts) {
            this.puts = puts;
        }

        void close() {
            puts.forEach(put -> put.library().close());
        }
    }

    /** A file in the state in which the last scans found it. */
    private static final class WatchedFile {
        @Nullable Stamp stamp;

        /** Stamp of the file with the parameters of this library; null if there is none. */
        @Nullable Stamp parameters;

        int equalLooks;

        /**
         * True if the file needs no work until it changes, except perhaps the report of its
         * refusal.
         */
        boolean settled;

        /** True if the file was passed to the world at least once. */
        boolean accepted;

        @Nullable PhysicsException refusal;
        int looksUntilTold;
        String told = "";

        void refuse(PhysicsException why, int looks) {
            settled = true;
            refusal = why;
            looksUntilTold = looks;
        }
    }

    /**
     * Creates a watcher; it scans only after {@link #start}, or when {@link #look} is called.
     *
     * @param origin {@link #ORIGIN} or {@link #UNTRUSTED_ORIGIN}
     * @param engine engine that prepares libraries; the caller closes it after this object
     * @param parameters reads the files with parameters, on the thread that scans
     * @throws IllegalArgumentException if the path is not a folder, or is world-writable
     */
    public LawFolder(
            String origin,
            Path folder,
            PhysicsEngine engine,
            Laws laws,
            CommandQueue commands,
            FolderParameters.Reader parameters) {
        this(origin, folder, engine, laws, commands, parameters, Trials.NONE);
    }

    /**
     * Creates a watcher like {@link #LawFolder(String, Path, PhysicsEngine, Laws, CommandQueue,
     * FolderParameters.Reader)}, with trials.
     *
     * @param trials tests new versions before they take over
     */
    public LawFolder(
            String origin,
            Path folder,
            PhysicsEngine engine,
            Laws laws,
            CommandQueue commands,
            FolderParameters.Reader parameters,
            Trials trials) {
        this.parameters = parameters;
        this.folder = require(folder);
        this.engine = engine;
        this.commands = commands;
        this.origin = origin;
        this.active = new FolderLaws(origin, laws, trials);
    }

    /** Starts a thread that scans every {@link #INTERVAL}. Called once. */
    public void start() {
        if (thread != null) {
            throw new IllegalStateException(folder + " is followed already");
        }
        thread = Thread.ofPlatform().daemon().name(origin).start(this::followUntilInterrupted);
    }

    /** Scans the folder once. This method is for callers that do not use {@link #start}. */
    public void look() {
        try {
            Map<String, Path> present = list();
            followRenames(present);
            for (String name : new TreeSet<>(files.keySet())) {
                if (!present.containsKey(name)) {
                    lookAtMissing(name, files.get(name));
                }
            }
            pending.removeIf(offered -> offered.isTaken);
            present.forEach(
                    (name, file) ->
                            lookAt(
                                    name,
                                    file,
                                    files.computeIfAbsent(name, n -> new WatchedFile())));
            offerReady();
        } catch (IOException | UncheckedIOException e) {
            warnOnce(folder + " is not followed, laws stay as they are: " + Reason.of(e));
        }
    }

    /**
     * Ends the scans; active laws stay active. Called after the world's last frame and before the
     * engine is closed.
     */
    @Override
    public void close() {
        Thread looking = thread;
        if (looking != null) {
            looking.interrupt();
            joinUninterruptibly(looking);
        }
        pending.forEach(Offered::close);
    }

    private static void joinUninterruptibly(Thread looking) {
        boolean interrupted = false;
        while (looking.isAlive()) {
            try {
                looking.join();
            } catch (InterruptedException e) {
                interrupted = true;
            }
        }
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }

    private void followUntilInterrupted() {
        try {
            while (true) {
                look();
                Thread.sleep(INTERVAL);
            }
        } catch (InterruptedException e) {
            // The interrupt comes from close(), so the thread ends.
        }
    }

    private Map<String, Path> list() throws IOException {
        Map<String, Path> present = new TreeMap<>();
        List<Path> all = FolderFiles.in(folder);
        if (isForEverybody(folder)) {
            // This check is made in every scan, because the path may lead to a new folder.
            throw new IOException("every user can write to it: chmod o-w it");
        }
        for (Path file : all) {
            String name = file.getFileName().toString();
            if (isLaw(name)) {
                present.put(name, file);
            }
        }
        return present;
    }

    private static boolean isLaw(String name) {
        return name.endsWith(".so")
                || name.endsWith(PreparedLibrary.TEXT_ENDING)
                || name.endsWith(PreparedLibrary.PYTHON_ENDING);
    }

    private void lookAtMissing(String name, WatchedFile file) {
        if (!file.accepted || offer(frame -> active.remove(frame, name))) {
            files.remove(name);
        }
    }

    private void lookAt(String name, Path path, WatchedFile file) {
        try {
            BasicFileAttributes attributes =
                    Files.readAttributes(
                            path, BasicFileAttributes.class, LinkOption.NOFOLLOW_LINKS);
            Stamp stamp = Stamp.of(attributes);
            Stamp parameters = stampOf(parameterFile(name));
            if (!stamp.equals(file.stamp) || !Objects.equals(parameters, file.parameters)) {
                file.stamp = stamp;
                file.parameters = parameters;
                file.equalLooks = 0;
                file.settled = false;
                file.refusal = null;
            }
            file.equalLooks++;
            if (!file.settled && file.equalLooks >= LOOKS_UNTIL_STABLE) {
                settle(name, path, attributes, file);
            }
            tellRefusal(name, file);
        } catch (NoSuchFileException e) {
            // The exception is ignored. The file was removed after it was listed, and the next scan
            // handles its removal.
        } catch (IOException e) {
            warnOnce(path + " cannot be read: " + e.getMessage());
        } catch (RuntimeException e) {
            // Only this file is skipped. The other files are still watched.
            warnOnce(path + " is ignored: " + e);
        }
    }

    private static @Nullable Stamp stampOf(Path file) throws IOException {
        try {
            return Stamp.of(
                    Files.readAttributes(
                            file, BasicFileAttributes.class, LinkOption.NOFOLLOW_LINKS));
        } catch (NoSuchFileException e) {
            return null;
        }
    }

    /** Returns the name of the library in a file: {@code wind} for {@code wind.law}. */
    private static String libraryIn(String name) {
        String library = name.substring(0, name.lastIndexOf('.'));
        return library.startsWith(PREFIX) ? library.substring(PREFIX.length()) : library;
    }

    private Path parameterFile(String name) throws IOException {
        try {
            return folder.resolve(libraryIn(name) + PARAMETERS_ENDING);
        } catch (InvalidPathException unwritable) {
            throw new IOException(
                    "the character set of the system cannot write its name (LC_ALL or LANG);"
                            + " expected UTF-8, for example LC_ALL=C.UTF-8",
                    unwritable);
        }
    }

    private FolderParameters parametersOf(String name) throws IOException {
        Path file = parameterFile(name);
        if (Files.notExists(file, LinkOption.NOFOLLOW_LINKS)) {
            return FolderParameters.NONE;
        }
        if (!Files.isRegularFile(file, LinkOption.NOFOLLOW_LINKS)) {
            throw new PhysicsException(
                    Status.INVALID_ARGUMENT,
                    file
                            + " cannot be read: expected a regular file with the parameters of "
                            + name);
        }
        return parameters.read(libraryIn(name), file);
    }

    private void settle(String name, Path path, BasicFileAttributes attributes, WatchedFile file)
            throws IOException {
        if (!attributes.isRegularFile()) {
            file.refuse(
                    new PhysicsException(
                            Status.INVALID_ARGUMENT,
                            path
                                    + " is ignored: expected a regular file, found "
                                    + (attributes.isSymbolicLink()
                                            ? "a symbolic link; copy the file itself here"
                                            : attributes.isDirectory()
                                                    ? "a folder"
                                                    : "a special file")),
                    0);
        } else if (!file.accepted && acceptedCount() + readyCount() >= MAX_LIBRARIES) {
            file.refuse(
                    new PhysicsException(
                            Status.INVALID_ARGUMENT,
                            path
                                    + " is ignored: the folder has "
                                    + MAX_LIBRARIES
                                    + " law libraries already; remove one, and drop it again"),
                    0);
        } else {
            try {
                prepare(name, path, file);
            } catch (PhysicsException e) {
                file.refuse(e, e.status() == Status.LIBRARY_LOAD_FAILED ? LOOKS_UNTIL_TOLD : 0);
            } catch (RuntimeException e) {
                file.refuse(
                        new PhysicsException(
                                Status.LIBRARY_LOAD_FAILED, path + " cannot be loaded: " + e),
                        0);
            }
        }
    }

    private void prepare(String name, Path path, WatchedFile file) throws IOException {
        FolderParameters given = parametersOf(name);
        ready.add(new Ready(file, new FolderLaws.Put(path, engine.prepare(path), given)));
        file.settled = true;
    }

    /** Passes the files that were found ready in this scan to the world, as one change. */
    private void offerReady() {
        if (ready.isEmpty()) {
            return;
        }
        List<FolderLaws.Put> puts = ready.stream().map(Ready::put).toList();
        Offered offered = new Offered(puts);
        boolean isOffered =
                offer(
                        frame -> {
                            offered.isTaken = true;
                            active.put(frame, puts);
                        });
        if (isOffered) {
            pending.add(offered);
        } else {
            offered.close();
        }
        for (Ready one : ready) {
            one.file.settled = isOffered;
            one.file.accepted |= isOffered;
        }
        ready.clear();
    }

    /**
     * Finds files that were renamed. Such a file had another name in the last scan. Their libraries
     * keep their place and continue to act.
     */
    private void followRenames(Map<String, Path> present) {
        Map<Stamp, String> known = new HashMap<>();
        files.forEach(
                (name, file) -> {
                    if (file.accepted && file.settled && file.stamp != null) {
                        known.put(file.stamp, name);
                    }
                });
        Map<String, String> oldByNew = new TreeMap<>();
        present.forEach(
                (name, path) -> {
                    String old = stampIfAny(path).map(known::get).orElse(name);
                    if (!old.equals(name) && endingOf(old).equals(endingOf(name))) {
                        oldByNew.put(name, old);
                    }
                });
        // Excludes files whose old name still exists, such as one of two hard links.
        oldByNew.values().removeIf(old -> present.containsKey(old) && !oldByNew.containsKey(old));
        if (oldByNew.isEmpty() || !offer(frame -> active.rename(oldByNew))) {
            return;
        }
        Map<String, WatchedFile> moved = new HashMap<>();
        oldByNew.forEach((name, old) -> moved.put(name, files.get(old)));
        files.keySet().removeAll(oldByNew.values());
        files.putAll(moved);
    }

    private static Optional<Stamp> stampIfAny(Path file) {
        try {
            return Optional.ofNullable(stampOf(file)).filter(stamp -> stamp.key() != null);
        } catch (IOException e) {
            return Optional.empty(); // lookAt reports the error
        }
    }

    private static String endingOf(String name) {
        return name.substring(name.lastIndexOf('.'));
    }

    private long readyCount() {
        return ready.stream().filter(one -> !one.file.accepted).count();
    }

    private long acceptedCount() {
        return files.values().stream().filter(file -> file.accepted).count();
    }

    /** Reports a refusal after the required number of scans, and the same refusal only once. */
    private void tellRefusal(String name, WatchedFile file) {
        PhysicsException refusal = file.refusal;
        if (refusal == null || file.equalLooks < file.looksUntilTold) {
            return;
        }
        String message = String.valueOf(refusal.getMessage());
        if (message.equals(file.told) || offer(frame -> active.refuse(frame, name, refusal))) {
            file.told = message;
            file.refusal = null;
        }
    }

    private boolean offer(FolderLaws.Change change) {
        return commands.offer(new FolderLaws.Entry(origin, sequence++, change));
    }

    private void warnOnce(String message) {
        if (!message.equals(lastWarning)) {
            lastWarning = message;
            LOG.warn("{}", message);
        }
    }

    /**
     * Checks that law libraries may be loaded from a folder, and returns its absolute path.
     *
     * @throws IllegalArgumentException if the path is not a folder, or is world-writable
     */
    public static Path require(Path folder) {
        if (!Files.isDirectory(folder)) {
            throw new IllegalArgumentException(
                    "laws folder " + folder + " is not a folder; create it, or name another");
        }
        try {
            if (isForEverybody(folder)) {
                throw new IllegalArgumentException(
                        "laws folder "
                                + folder
                                + " can be written by every user, and its libraries are run: chmod"
                                + " o-w it, or name another");
            }
        } catch (IOException e) {
            throw new IllegalArgumentException("laws folder " + folder + " cannot be read", e);
        }
        return folder.toAbsolutePath();
    }

    private static boolean isForEverybody(Path folder) throws IOException {
        return Files.getPosixFilePermissions(folder).contains(PosixFilePermission.OTHERS_WRITE);
    }
}
