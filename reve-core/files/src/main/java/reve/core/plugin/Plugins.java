// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import org.jspecify.annotations.Nullable;

import reve.core.access.ActionProvider;
import reve.core.frame.FrameListenerProvider;
import reve.core.world.SensorProvider;
import reve.core.world.SymbolProvider;

import java.io.IOException;
import java.net.URLClassLoader;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.ServiceConfigurationError;
import java.util.ServiceLoader;
import java.util.stream.Stream;

/**
 * The plugins of an operator. Each plugin is a jar with its own class loader, whose parent is the
 * class loader of the program. Plugins therefore do not see each other's classes.
 *
 * <p>A command passes its plugins on with the context class loader of its thread, which new threads
 * inherit, see {@link #contextLoader()}. World files, stores and recordings that these threads read
 * may then name the actions, symbols and sensors of the plugins. For any thread.
 */
public final class Plugins implements AutoCloseable {
    /** No plugins. The providers on the class path can still be named. */
    public static final Plugins NONE = new Plugins(List.of());

    private final List<PluginJar> jars;

    Plugins(List<PluginJar> jars) {
        this.jars = List.copyOf(jars);
    }

    /**
     * Opens the jars of a folder in the order of their names: regular files whose names end in
     * {@code .jar}. The caller closes the result after the last use of a provider.
     *
     * @param folder a folder that not every user may write, because its code runs with all rights
     *     of the process
     * @throws PluginException with one message for each problem if a jar is damaged, has no
     *     providers, or has a provider that cannot be created or has a name that is taken
     */
    public static Plugins open(Path folder) throws PluginException {
        return PluginFolder.open(folder);
    }

    /**
     * Returns the plugins of the calling thread, which its context class loader contains; {@link
     * #NONE} if it contains none.
     */
    public static Plugins current() {
        ClassLoader loader = Thread.currentThread().getContextClassLoader();
        while (loader != null) {
            if (loader instanceof Context context) {
                return context.plugins();
            }
            loader = loader.getParent();
        }
        return NONE;
    }

    /**
     * Returns a class loader to set as the context class loader of the thread that uses the
     * plugins. Threads that this thread creates inherit it.
     */
    public ClassLoader contextLoader() {
        return new Context(this);
    }

    /** Returns the identities of the plugins, in the order of their names. */
    public List<PluginInfo> infos() {
        return jars.stream().map(PluginJar::info).toList();
    }

    /**
     * Returns the actions of the plugins, then those on the class path.
     *
     * @throws ServiceConfigurationError if a provider on the class path cannot be created
     */
    public List<ActionProvider> actions() {
        return withClassPath(ActionProvider.class, jars.stream().map(PluginJar::actions));
    }

    /** Returns the providers of symbols, like {@link #actions()}. */
    public List<SymbolProvider> symbols() {
        return withClassPath(SymbolProvider.class, jars.stream().map(PluginJar::symbols));
    }

    /** Returns the providers of sensors, like {@link #actions()}. */
    public List<SensorProvider> sensors() {
        return withClassPath(SensorProvider.class, jars.stream().map(PluginJar::sensors));
    }

    /**
     * Returns the makers of frame listeners of the plugins. Those on the class path are not
     * included, because a program adds its own listeners to the frame bus.
     */
    public List<FrameListenerProvider> listeners() {
        return jars.stream().flatMap(jar -> jar.listeners().stream()).toList();
    }

    private static <T> List<T> withClassPath(Class<T> type, Stream<List<T>> ofPlugins) {
        List<T> all = new ArrayList<>();
        ofPlugins.forEach(all::addAll);
        all.addAll(onClassPath(type));
        return all;
    }

    static <T> List<T> onClassPath(Class<T> type) {
        return ServiceLoader.load(type).stream().map(ServiceLoader.Provider::get).toList();
    }

    /** Closes the jars. Idempotent. */
    @Override
    public void close() {
        for (PluginJar jar : jars) {
            close(jar.loader());
        }
    }

    static void close(URLClassLoader loader) {
        try {
            loader.close();
        } catch (IOException unneeded) {
            // the jar was only read
        }
    }

    /** A class loader that contains no classes, and refers to plugins. */
    private static final class Context extends ClassLoader {
        private final Plugins plugins;

        Context(Plugins plugins) {
            super("plugins", parent());
            this.plugins = plugins;
        }

        private static @Nullable ClassLoader parent() {
            return Plugins.class.getClassLoader();
        }

        Plugins plugins() {
            return plugins;
        }
    }
}
