// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import org.jspecify.annotations.Nullable;

import reve.core.access.ActionProvider;
import reve.core.frame.FrameListenerProvider;
import reve.core.text.Visible;
import reve.core.world.Gauge;
import reve.core.world.SensorProvider;
import reve.core.world.SymbolProvider;

import java.io.IOException;
import java.net.URL;
import java.net.URLClassLoader;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermission;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.ServiceConfigurationError;
import java.util.ServiceLoader;
import java.util.function.Consumer;
import java.util.function.Function;
import java.util.jar.Attributes;
import java.util.jar.JarFile;
import java.util.jar.Manifest;
import java.util.stream.Stream;

/** Opens the jars of a folder, and collects their problems. For one thread. */
final class PluginFolder {
    private static final String ENDING = ".jar";
    private static final String SERVICES = "META-INF/services/";

    /** The types of providers, by what messages call them. */
    private static final Map<String, Class<?>> TYPES =
            Map.of(
                    "action", ActionProvider.class,
                    "symbol", SymbolProvider.class,
                    "sensor", SensorProvider.class,
                    "listener", FrameListenerProvider.class);

    private final List<String> problems = new ArrayList<>();
    private final List<PluginJar> jars = new ArrayList<>();

    /** The names of providers so far, by type and name, with the file that has them. */
    private final Map<String, String> taken = new HashMap<>();

    private PluginFolder() {}

    /** Opens the jars of a folder, see {@link Plugins#open}. */
    static Plugins open(Path folder) throws PluginException {
        var reader = new PluginFolder();
        reader.readAll(folder);
        Plugins plugins = new Plugins(reader.jars);
        if (!reader.problems.isEmpty()) {
            plugins.close();
            throw new PluginException(reader.problems);
        }
        return plugins;
    }

    private void readAll(Path folder) {
        if (!Files.isDirectory(folder)) {
            problems.add(
                    "plugins folder "
                            + shown(folder)
                            + " is not a folder; create it, or name another");
            return;
        }
        List<Path> files;
        try (Stream<Path> listed = Files.list(folder)) {
            if (isForEverybody(folder)) {
                problems.add(refusal("plugins folder " + shown(folder)));
                return;
            }
            files = listed.filter(file -> file.toString().endsWith(ENDING)).sorted().toList();
        } catch (IOException unreadable) {
            problems.add(
                    "plugins folder "
                            + shown(folder)
                            + " cannot be read: "
                            + unreadable.getMessage());
            return;
        }
        if (files.isEmpty()) {
            problems.add(
                    "plugins folder "
                            + shown(folder)
                            + " has no file that ends in .jar; name a folder with plugins");
            return;
        }
        takeClassPath();
        for (Path file : files) {
            read(file);
        }
    }

    private void read(Path file) {
        String name = shown(file);
        try {
            if (!Files.isRegularFile(file, LinkOption.NOFOLLOW_LINKS)) {
                problems.add(name + " is not a regular file; copy the jar into the folder");
                return;
            }
            if (isForEverybody(file)) {
                problems.add(refusal(name));
                return;
            }
            PluginInfo info = info(file);
            if (info == null) {
                return;
            }
            load(file, info);
        } catch (IOException damaged) {
            problems.add(
                    name
                            + " cannot be read as a jar: "
                            + Visible.line(String.valueOf(damaged.getMessage()))
                            + "; build it again");
        }
    }

    /** Returns the identity of a plugin; null if it has no providers, which was then recorded. */
    private @Nullable PluginInfo info(Path file) throws IOException {
        try (JarFile jar = new JarFile(file.toFile())) {
            boolean provides =
                    TYPES.values().stream()
                            .anyMatch(type -> jar.getEntry(SERVICES + type.getName()) != null);
            if (!provides) {
                problems.add(
                        shown(file)
                                + " provides nothing; expected one of the files "
                                + String.join(
                                        ", ",
                                        TYPES.values().stream()
                                                .map(type -> SERVICES + type.getName())
                                                .sorted()
                                                .toList())
                                + " in it (a module-info is not read)");
                return null;
            }
            Manifest manifest = jar.getManifest();
            return new PluginInfo(
                    file.getFileName().toString(),
                    sha256(Files.readAllBytes(file)),
                    Optional.ofNullable(manifest)
                            .map(Manifest::getMainAttributes)
                            .map(all -> all.getValue(Attributes.Name.IMPLEMENTATION_VERSION))
                            .map(Visible::line));
        }
    }

    private void load(Path file, PluginInfo info) throws IOException {
        URLClassLoader loader =
                new URLClassLoader(
                        info.file(),
                        new URL[] {file.toUri().toURL()},
                        Plugins.class.getClassLoader());
        int before = problems.size();
        var jar =
                new PluginJar(
                        info,
                        loader,
                        providers(
                                file,
                                loader,
                                "action",
                                ActionProvider.class,
                                ActionProvider::name,
                                ActionProvider::parameters),
                        providers(
                                file,
                                loader,
                                "symbol",
                                SymbolProvider.class,
                                SymbolProvider::name,
                                SymbolProvider::doc),
                        providers(
                                file,
                                loader,
                                "sensor",
                                SensorProvider.class,
                                SensorProvider::name,
                                Gauge::numbers),
                        providers(
                                file,
                                loader,
                                "listener",
                                FrameListenerProvider.class,
                                FrameListenerProvider::name,
                                FrameListenerProvider::doc));
        if (problems.size() == before && jar.isEmpty()) {
            problems.add(
                    shown(file)
                            + " provides nothing: the classes that it lists in "
                            + SERVICES
                            + " are not in the jar");
        }
        if (problems.size() == before) {
            jars.add(jar);
        } else {
            Plugins.close(loader);
        }
    }

    /**
     * Creates the providers of one type. Records a problem and returns no providers if one of them
     * cannot be created or has a name that is taken.
     */
    private <T> List<T> providers(
            Path file,
            ClassLoader loader,
            String what,
            Class<T> type,
            Function<T, String> nameOf,
            Consumer<T> check) {
        List<T> found = new ArrayList<>();
        try {
            // The loader also finds the providers of its parent, which are not in the jar.
            List<ServiceLoader.Provider<T>> listed =
                    ServiceLoader.load(type, loader).stream()
                            .filter(provider -> provider.type().getClassLoader() == loader)
                            .toList();
            for (ServiceLoader.Provider<T> provider : listed) {
                T made = provider.get();
                String name = nameOf.apply(made);
                if (name == null || name.isBlank()) {
                    problems.add(
                            shown(file)
                                    + ": the "
                                    + what
                                    + " of class "
                                    + made.getClass().getName()
                                    + " has no name; expected one such as example."
                                    + what);
                    return List.of();
                }
                check.accept(made);
                if (!take(file, what, name)) {
                    return List.of();
                }
                found.add(made);
            }
        } catch (UnsupportedClassVersionError newer) {
            problems.add(
                    shown(file)
                            + " was compiled for a newer Java: "
                            + newer.getMessage()
                            + "; compile it with --release "
                            + Runtime.version().feature());
            return List.of();
        } catch (ServiceConfigurationError | Exception | LinkageError | AssertionError broken) {
            problems.add(shown(file) + ": its " + what + " cannot be created: " + reason(broken));
            return List.of();
        }
        return found;
    }

    /** Takes the names of the providers on the class path, which plugins must not have. */
    private void takeClassPath() {
        try {
            Plugins.onClassPath(ActionProvider.class).forEach(each -> take("action", each.name()));
            Plugins.onClassPath(SymbolProvider.class).forEach(each -> take("symbol", each.name()));
            Plugins.onClassPath(SensorProvider.class).forEach(each -> take("sensor", each.name()));
        } catch (ServiceConfigurationError broken) {
            problems.add("the class path has a broken provider: " + reason(broken));
        }
    }

    private void take(String what, String name) {
        taken.put(what + " " + name, "a jar on the class path");
    }

    private boolean take(Path file, String what, String name) {
        String other = taken.putIfAbsent(what + " " + name, shown(file));
        if (other != null) {
            problems.add(
                    shown(file)
                            + ": the "
                            + what
                            + " "
                            + Visible.line(name)
                            + " is also in "
                            + other
                            + "; remove one of the jars, or give it another name");
        }
        return other == null;
    }

    private static String reason(Throwable broken) {
        Throwable cause = broken;
        while (cause.getCause() != null) {
            cause = cause.getCause();
        }
        String ofCause = cause == broken ? "" : " (" + cause + ")";
        return Visible.line(broken.getMessage() == null ? broken.toString() : broken.getMessage())
                + Visible.line(ofCause);
    }

    private static String refusal(String what) {
        return what + " can be written by every user, and its code is run: chmod o-w it";
    }

    private static boolean isForEverybody(Path path) throws IOException {
        return Files.getPosixFilePermissions(path).contains(PosixFilePermission.OTHERS_WRITE);
    }

    private static String shown(Path path) {
        return Visible.line(path.toString());
    }

    private static String sha256(byte[] bytes) {
        try {
            return HexFormat.of().formatHex(MessageDigest.getInstance("SHA-256").digest(bytes));
        } catch (NoSuchAlgorithmException impossible) {
            throw new IllegalStateException(impossible); // each Java runtime has it
        }
    }
}
