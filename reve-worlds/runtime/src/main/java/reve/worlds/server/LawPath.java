// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;
import reve.core.text.Suggestion;
import reve.core.text.Visible;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Status;
import reve.pe.adapter.LawLibrary;
import reve.pe.hosted.ApartRule;
import reve.pe.posix.RegularFile;
import reve.pe.vesper.LibraryFile;
import reve.worlds.Product;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.TreeSet;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * The search path of laws. It also decides which native code may be opened. A name is searched
 * among the shipped laws, then in the operator's folder, then in {@code laws/} beside the world
 * file. Code from {@code laws/} beside the world file, from a store or from a recording came with
 * the world. Such code is opened only in one of three cases: the operator trusts the world, the
 * bytes equal those of a library of the first two places, or the code runs in a sandbox. The
 * operator may also name a folder of untrusted laws, which is searched after the first two places.
 * Its laws always run in a sandbox. For any thread.
 *
 * @param shipped folder of the shipped laws
 * @param folder the operator's folder
 * @param world folder of the world file
 * @param trusted whether native code that came with the world may be opened
 * @param place process in which the laws run
 * @param validated whether laws run on guarded copies of the columns, which detects accesses that a
 *     law does not declare but is slower
 * @param excluded names of libraries that must not act, whatever their origin
 * @param sandboxed the laws that run in a sandbox; the place must then be another process
 */
public record LawPath(
        Path shipped,
        Optional<Path> folder,
        Optional<Path> world,
        boolean trusted,
        EnginePlace place,
        boolean validated,
        Set<String> excluded,
        Sandboxed sandboxed) {
    private static final Pattern NAME = Pattern.compile("[A-Za-z0-9_-]{1,47}");

    /** An absolute path in a message. */
    private static final Pattern FOLDER = Pattern.compile("(?<![\\w)])/\\S");

    /**
     * End of messages to remote operators. The messages omit folders of the server, because remote
     * operators must not learn them.
     */
    static final String SEE_LOG = "; the server's log says why";

    private static final String PREFIX = "libvesper_law_";
    private static final String SUFFIX = ".so";
    private static final String WORLDS_OWN = "laws";

    /** Suffixes of files with a law's source code. */
    private static final List<String> SOURCES =
            List.of(PreparedLibrary.TEXT_ENDING, PreparedLibrary.PYTHON_ENDING);

    /** Creates a search path of laws that run in this process, without validation. */
    public LawPath(Path shipped, Optional<Path> folder, Optional<Path> world, boolean trusted) {
        this(
                shipped,
                folder,
                world,
                trusted,
                EnginePlace.IN_PROCESS,
                false,
                Set.of(),
                Sandboxed.NONE);
    }

    /** Copies the excluded names. */
    public LawPath {
        excluded = Set.copyOf(excluded);
        if (sandboxed.isUsed() && place == EnginePlace.IN_PROCESS) {
            throw new IllegalArgumentException("laws run apart only beside a hosted engine");
        }
    }

    /** The origin of a library. */
    public enum Origin {
        /** A library that is shipped with the release. */
        SHIPPED,
        /** A library from the operator's {@code --laws} folder. */
        FOLDER,
        /** A library from the operator's {@code --untrusted} folder. */
        UNTRUSTED,
        /** A library that came with the world. */
        WORLD
    }

    /** The file found for a name. */
    public record Found(Path file, Origin origin) {
        /** Returns whether the library is a law as text, which cannot harm the process. */
        boolean isText() {
            return file.toString().endsWith(PreparedLibrary.TEXT_ENDING);
        }
    }

    /** Returns a copy of this path with validation on or off. */
    public LawPath withValidation(boolean on) {
        return new LawPath(shipped, folder, world, trusted, place, on, excluded, sandboxed);
    }

    /** Returns a copy of this path without the libraries of these names. */
    public LawPath without(Set<String> names) {
        return new LawPath(shipped, folder, world, trusted, place, validated, names, sandboxed);
    }

    /** Returns whether the law of a world file, or the library, is excluded by its name. */
    boolean isExcluded(String name) {
        String bare = name;
        for (String ending : SOURCES) {
            bare =
                    bare.endsWith(ending)
                            ? bare.substring(0, bare.length() - ending.length())
                            : bare;
        }
        return excluded.contains(name) || excluded.contains(bare);
    }

    /** Returns a path of the shipped laws only. */
    public static LawPath ofShipped() {
        return new LawPath(
                Product.nativeFolder().resolve("laws"), Optional.empty(), Optional.empty(), false);
    }

    /** Returns a copy of this path for a world whose file is in this folder. */
    public LawPath forWorld(Path worldFolder) {
        return new LawPath(
                shipped,
                folder,
                Optional.of(worldFolder),
                trusted,
                place,
                validated,
                excluded,
                sandboxed);
    }

    /**
     * Finds the library of a law without opening it.
     *
     * @throws PhysicsException if there is none, or the library beside the world file is not a
     *     regular file in that folder
     */
    public Found find(String name) {
        List<String> files = filesOf(name);
        for (Map.Entry<Path, Origin> place : operatorsPlaces().entrySet()) {
            List<Path> candidates =
                    files.stream()
                            .map(place.getKey()::resolve)
                            .filter(file -> Files.exists(file, LinkOption.NOFOLLOW_LINKS))
                            .map(Path::toAbsolutePath)
                            .toList();
            if (place.getValue() != Origin.SHIPPED) {
                requireOne(name, candidates);
                candidates.forEach(LawPath::requireRegular);
            }
            if (!candidates.isEmpty()) {
                return new Found(candidates.getFirst(), place.getValue());
            }
        }
        return worldsOwn(name)
                .map(own -> new Found(own, Origin.WORLD))
                .orElseThrow(
                        () ->
                                new PhysicsException(
                                        Status.NOT_FOUND,
                                        "law library '"
                                                + name
                                                + "' was not found among "
                                                + places()
                                                + misplaced(name)
                                                        .orElseGet(() -> suggestion(name))));
    }

    /**
     * Returns a remedy if the world comes with a file for a law, but the file is not in the folder
     * of its laws, or has another ending.
     */
    private Optional<String> misplaced(String name) {
        List<String> files = name.contains(".") ? List.of(name) : filesOf(name);
        for (String place : List.of("", "law", WORLDS_OWN)) {
            for (String file : regularFiles(world.map(own -> own.resolve(place)))) {
                String found = Visible.line(place.isEmpty() ? file : place + "/" + file);
                if (files.contains(file)) {
                    return Optional.of(
                            "; the world has the file "
                                    + found
                                    + ": move it into the folder "
                                    + WORLDS_OWN
                                    + "/ beside the world file");
                }
                if (file.equals(name + ".txt")) {
                    return Optional.of(
                            "; the world has the file "
                                    + found
                                    + ": if it is a law as text, rename it to "
                                    + WORLDS_OWN
                                    + "/"
                                    + name
                                    + PreparedLibrary.TEXT_ENDING);
                }
            }
        }
        return Optional.empty();
    }

    private static List<String> regularFiles(Optional<Path> folder) {
        if (folder.isEmpty() || !Files.isDirectory(folder.get(), LinkOption.NOFOLLOW_LINKS)) {
            return List.of();
        }
        try (Stream<Path> files = Files.list(folder.get())) {
            return files.filter(file -> Files.isRegularFile(file, LinkOption.NOFOLLOW_LINKS))
                    .map(file -> file.getFileName().toString())
                    .sorted()
                    .toList();
        } catch (IOException | UncheckedIOException unreadable) {
            return List.of(); // an unreadable folder has no file to suggest
        }
    }

    /**
     * Returns why a law cannot be opened, for a client. The message names laws and files, but no
     * folder of the server.
     */
    String reasonForClients(String name, PhysicsException refused) {
        if (refused.status() == Status.NOT_FOUND) {
            return "no law is called \"" + name + "\"" + suggestion(name);
        }
        String message = String.valueOf(refused.getMessage());
        for (Path place : operatorsPlaces().keySet()) {
            message = message.replace(shown(place.toAbsolutePath()) + "/", "");
        }
        if (world.isPresent()) {
            message = message.replace(shown(world.get().toAbsolutePath()) + "/", "");
        }
        return FOLDER.matcher(message).find()
                ? "the library \"" + name + "\" is refused: " + refused.status() + SEE_LOG
                : message;
    }

    /** Returns the names of the laws that ship. */
    Set<String> shippedNames() {
        return Set.copyOf(namesIn(shipped));
    }

    /** Returns whether the law is in the world's own folder and must not be opened. */
    public boolean needsTrust(String name) {
        try {
            Found found = find(name);
            return needsTrust(found);
        } catch (PhysicsException refused) {
            return false;
        }
    }

    private boolean needsTrust(Found found) {
        boolean isPython = found.file().toString().endsWith(PreparedLibrary.PYTHON_ENDING);
        return found.origin() == Origin.WORLD
                && !trusted
                && !found.isText()
                && (isPython || !sandboxed.worlds());
    }

    /**
     * Returns the message which states that a law of the world's own folder is not opened, and why.
     */
    public String untrusted(String name) {
        String file = find(name).file().getFileName().toString();
        return "law '"
                + name
                + "' comes with the world, in "
                + WORLDS_OWN
                + "/"
                + file
                + ": "
                + (file.endsWith(PreparedLibrary.PYTHON_ENDING)
                        ? "a program, which runs with all of your rights and is opened only with"
                                + " --trust"
                        : "native code, which runs with all of your rights and is opened only with"
                                + " --trust, or in a sandbox with --apart");
    }

    /**
     * Returns a message if the found law hides a library in the world's own folder, that is, a
     * library with the same name and other bytes.
     */
    Optional<String> hidden(String name, Found found) {
        try {
            Optional<Path> own =
                    found.origin() == Origin.WORLD ? Optional.empty() : worldsOwn(name);
            return own.isEmpty() || Files.mismatch(own.get(), found.file()) < 0
                    ? Optional.empty()
                    : Optional.of(
                            own.get()
                                    + " is not used: the law of that name "
                                    + switch (found.origin()) {
                                        case SHIPPED -> "that ships";
                                        case FOLDER, WORLD -> "in --laws";
                                        case UNTRUSTED -> "in --untrusted";
                                    }
                                    + " comes first; give it a name of its own");
        } catch (IOException | PhysicsException unreadable) {
            return Optional.of(
                    WORLDS_OWN + "/" + name + " is not used: " + unreadable.getMessage());
        }
    }

    /**
     * Opens the library of a law.
     *
     * @throws PhysicsException as in {@link #find}; also if the library comes with the world and
     *     the operator does not trust the world
     */
    PreparedLibrary prepare(PhysicsEngine engine, String name, Found found) {
        if (needsTrust(found)) {
            throw new PhysicsException(Status.LIBRARY_LOAD_FAILED, untrusted(name));
        }
        return engine.prepare(found.file());
    }

    /**
     * Refuses a library that is excluded. Also refuses a library if its own name, or the name of
     * one of its laws, is the name of a shipped law, because users would confuse the two.
     *
     * @param library bytes of the file; shipped libraries and their copies may have these names
     * @throws PhysicsException naming both files; for a library without a folder, naming no file
     */
    void requireOwnName(String name, Path file, byte[] library) {
        if (isExcluded(name)) {
            throw new PhysicsException(
                    Status.ACCESS_CONFLICT,
                    "'"
                            + Visible.line(name)
                            + "' is excluded by --without-law: restart the server without this"
                            + " option to load it");
        }
        Path ships = shipped.resolve(PREFIX + name + SUFFIX);
        if (!Files.exists(ships)) {
            ships = shipped.resolve(name + PreparedLibrary.TEXT_ENDING);
        }
        if (NAME.matcher(name).matches() && Files.exists(ships) && !holds(shipped, library)) {
            // The texts and libraries of messages have a name without a folder. Their senders need
            // not know the server's folders, nor which files they contain.
            boolean isFile = file.getParent() != null;
            throw new PhysicsException(
                    Status.ALREADY_EXISTS,
                    (isFile ? shown(file.toAbsolutePath()) : "the law")
                            + " calls itself '"
                            + Visible.line(name)
                            + "', which is the "
                            + (isFile
                                    ? "law that ships as " + ships.toAbsolutePath()
                                    : "name of a shipped law")
                            + "; give it a name of its own");
        }
    }

    /**
     * Refuses a library of a store or a recording unless the world is trusted, the operator's
     * folders contain it, or it is in {@link KnownLaws}.
     *
     * @throws PhysicsException naming it
     */
    void requireKnown(LawLibrary library) {
        boolean runsApart = sandboxed.worlds() && !PreparedLibrary.isPython(library.bytes());
        if (!trusted
                && !runsApart
                && !library.isText()
                && !isOperators(library)
                && !KnownLaws.contains(library.sha256(), folder)
                && !wasUntrusted(library)) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    "the law library '"
                            + Visible.line(library.name())
                            + "' (SHA-256 "
                            + library.sha256()
                            + ") in it is native code, which runs with all of your rights, and"
                            + " equals none of the laws that ship"
                            + folder.map(own -> " or lie in " + shown(own)).orElse("")
                            + ": it is opened only with --trust, in a sandbox with --apart, or with"
                            + " --laws DIR that has it");
        }
    }

    /**
     * Returns whether native code was in the operator's folder of untrusted laws when this account
     * stored the world. If so, the code runs in a sandbox again.
     */
    private boolean wasUntrusted(LawLibrary library) {
        return !PreparedLibrary.isPython(library.bytes())
                && sandboxed
                        .folder()
                        .map(own -> KnownLaws.containsUntrusted(library.sha256(), own))
                        .orElse(false);
    }

    /**
     * Decides how a library is isolated from the engine and other laws; see {@link ApartRule#of}.
     * Libraries of unknown origin, for example those of an image, also run in a sandbox.
     */
    ApartRule.Isolation isolation(Optional<Path> file, byte[] library) {
        Optional<Path> own = sandboxed.folder();
        if (!sandboxed.isUsed()) {
            return ApartRule.Isolation.NONE;
        }
        boolean isFromFolder =
                own.isPresent()
                        && file.map(path -> path.toAbsolutePath().startsWith(own.get()))
                                .orElse(false);
        boolean isTrusted =
                !isFromFolder
                        && (holds(shipped, library)
                                || folder.map(laws -> holds(laws, library)).orElse(false)
                                || !own.map(laws -> holds(laws, library)).orElse(false)
                                        && (trusted
                                                || KnownLaws.contains(
                                                        LibraryFile.sha256(library), folder)));
        return isTrusted
                ? ApartRule.Isolation.NONE
                : sandboxed.weakly() ? ApartRule.Isolation.APART_WEAKLY : ApartRule.Isolation.APART;
    }

    /**
     * Adds libraries of a stored world to {@link KnownLaws}, because their files may be replaced
     * before the store is opened again. Adds only libraries that ship with this release or come
     * from the operator's folders. Reads files.
     */
    void remember(List<LawLibrary> libraries) {
        List<LawLibrary> opened = libraries.stream().filter(library -> !library.isText()).toList();
        KnownLaws.keep(opened.stream().filter(this::ships).toList(), Optional.empty());
        // Only libraries of the operator and of the release can have been opened without these
        // options. This is true even if the content of the folder has changed meanwhile.
        boolean onlyOperators = !trusted && !sandboxed.isUsed();
        folder.ifPresent(
                own ->
                        KnownLaws.keep(
                                opened.stream()
                                        .filter(library -> !ships(library))
                                        .filter(
                                                library ->
                                                        onlyOperators
                                                                || holds(own, library.bytes()))
                                        .toList(),
                                folder));
        // These libraries may include a library of --laws whose file was replaced. Such a library
        // then also runs in a sandbox.
        boolean onlyFolders = !trusted && !sandboxed.worlds();
        sandboxed
                .folder()
                .ifPresent(
                        untrusted ->
                                KnownLaws.keepUntrusted(
                                        opened.stream()
                                                .filter(library -> !ships(library))
                                                .filter(
                                                        library ->
                                                                !PreparedLibrary.isPython(
                                                                        library.bytes()))
                                                .filter(
                                                        library ->
                                                                onlyFolders && !isInFolder(library)
                                                                        || holds(
                                                                                untrusted,
                                                                                library.bytes()))
                                                .toList(),
                                        untrusted));
    }

    private boolean isInFolder(LawLibrary library) {
        return folder.map(own -> holds(own, library.bytes())).orElse(false);
    }

    /** Returns whether a shipped file has the bytes of a library. */
    boolean ships(LawLibrary library) {
        return holds(shipped, library.bytes());
    }

    private boolean isOperators(LawLibrary library) {
        return operatorsPlaces().keySet().stream().anyMatch(place -> holds(place, library.bytes()));
    }

    private Map<Path, Origin> operatorsPlaces() {
        Map<Path, Origin> places = new LinkedHashMap<>();
        places.put(shipped, Origin.SHIPPED);
        folder.ifPresent(own -> places.putIfAbsent(own, Origin.FOLDER));
        sandboxed.folder().ifPresent(own -> places.putIfAbsent(own, Origin.UNTRUSTED));
        return places;
    }

    private String places() {
        return "the laws that ship"
                + folder.map(own -> ", in " + shown(own)).orElse("")
                + sandboxed.folder().map(own -> ", in " + shown(own)).orElse("")
                + world.map(_ -> ", or in the world's own folder " + WORLDS_OWN + "/").orElse("");
    }

    /**
     * Returns the names of all libraries on the search path, in alphabetical order. Reads folders.
     */
    List<String> names() {
        SortedSet<String> names = new TreeSet<>();
        Stream.concat(
                        operatorsPlaces().keySet().stream(),
                        world
                                .map(own -> own.resolve(WORLDS_OWN))
                                .filter(own -> Files.isDirectory(own, LinkOption.NOFOLLOW_LINKS))
                                .stream())
                .forEach(place -> names.addAll(namesIn(place)));
        return List.copyOf(names);
    }

    /** Returns a suggestion for a name that was not found: the most similar name, or all names. */
    private String suggestion(String wrong) {
        List<String> names = names();
        String near = Suggestion.of(wrong, names);
        return near.isEmpty() ? "; known are " + String.join(", ", names) : near;
    }

    /** Lists the laws of a folder. Ignores pipes, because opening a pipe would block. */
    private static List<String> namesIn(Path folder) {
        if (!Files.isDirectory(folder)) {
            return List.of();
        }
        try (Stream<Path> files = Files.list(folder)) {
            return files.map(file -> file.getFileName().toString())
                    .flatMap(file -> nameOf(file).stream())
                    .toList();
        } catch (IOException unreadable) {
            return List.of(); // an unreadable folder has no names to suggest
        }
    }

    /**
     * Returns the name of the law that belongs to a file name; empty if the file contains no law.
     * File names come with a world, so they may contain anything.
     */
    private static Optional<String> nameOf(String file) {
        Optional<String> name =
                file.startsWith(PREFIX) && file.endsWith(SUFFIX)
                        ? Optional.of(
                                file.substring(PREFIX.length(), file.length() - SUFFIX.length()))
                        : SOURCES.stream()
                                .filter(file::endsWith)
                                .findFirst()
                                .map(ending -> file.substring(0, file.length() - ending.length()));
        return name.filter(found -> NAME.matcher(found).matches());
    }

    /** Returns a path as it appears in a message of several lines. */
    private static String shown(Path path) {
        return Visible.line(path.toString());
    }

    /** Refuses links, pipes and devices. The code that watches the folder also refuses them. */
    private static void requireRegular(Path file) {
        String other;
        try {
            other = RegularFile.otherKind(file);
        } catch (IOException unreadable) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    shown(file) + " cannot be read: " + unreadable.getMessage());
        }
        if (!other.isEmpty()) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    shown(file) + " is not read: expected a regular file, found " + other);
        }
    }

    /** Refuses two files for one name in a folder that the release does not contain. */
    private static void requireOne(String name, List<Path> candidates) {
        if (candidates.size() > 1) {
            throw new PhysicsException(
                    Status.ALREADY_EXISTS,
                    "law '"
                            + name
                            + "' is there twice, as "
                            + shown(candidates.getFirst())
                            + " and as "
                            + shown(candidates.getLast())
                            + "; remove one of them, or write "
                            + candidates.getFirst().getFileName()
                            + " or "
                            + candidates.getLast().getFileName()
                            + " for one of them");
        }
    }

    /**
     * Returns the names of the files for a law, in order of preference: the compiled library, the
     * text, the file in Python. A name that ends in ".law" or ".py" is the name of a file.
     */
    public static List<String> filesOf(String name) {
        for (String ending : SOURCES) {
            if (name.endsWith(ending)) {
                filesOf(name.substring(0, name.length() - ending.length()));
                return List.of(name);
            }
        }
        if (!NAME.matcher(name).matches()) {
            throw new PhysicsException(
                    Status.INVALID_ARGUMENT,
                    "'"
                            + Visible.line(name)
                            + "' is no name of a "
                            + "law: expected letters, digits, _ and -, 47 of them at most");
        }
        return List.of(
                PREFIX + name + SUFFIX,
                name + PreparedLibrary.TEXT_ENDING,
                name + PreparedLibrary.PYTHON_ENDING);
    }

    private Optional<Path> worldsOwn(String name) {
        List<Path> found =
                filesOf(name).stream().map(this::worldsOwnFile).flatMap(Optional::stream).toList();
        requireOne(name, found);
        return found.stream().findFirst();
    }

    /** Returns a regular file in the world's own folder. A link must not lead out of the folder. */
    private Optional<Path> worldsOwnFile(String file) {
        if (world.isEmpty()
                || !Files.exists(
                        world.get().resolve(WORLDS_OWN).resolve(file), LinkOption.NOFOLLOW_LINKS)) {
            return Optional.empty();
        }
        String path = WORLDS_OWN + "/" + file;
        try {
            Path real = new WorldFolder(world.get()).find(path);
            if (!real.startsWith(world.get().toRealPath().resolve(WORLDS_OWN))) {
                throw new PhysicsException(
                        Status.LIBRARY_LOAD_FAILED,
                        path + ": a link that leads out of the world's folder " + WORLDS_OWN + "/");
            }
            return Optional.of(real);
        } catch (AssetException | IOException refused) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED, String.valueOf(refused.getMessage()));
        }
    }

    private static boolean holds(Path folder, byte[] library) {
        try (Stream<Path> files = Files.list(folder)) {
            return files.filter(Files::isRegularFile).anyMatch(file -> equal(file, library));
        } catch (IOException unreadable) {
            return false;
        }
    }

    private static boolean equal(Path file, byte[] library) {
        try {
            return Files.size(file) == library.length
                    && Arrays.equals(Files.readAllBytes(file), library);
        } catch (IOException | UncheckedIOException failure) {
            return false;
        }
    }
}
