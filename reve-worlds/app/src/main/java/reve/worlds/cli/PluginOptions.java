// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Option;

import reve.core.plugin.PluginException;
import reve.core.plugin.Plugins;

import java.nio.file.Path;
import java.util.Optional;

/** The option that names the folder of plugins. */
final class PluginOptions {
    @Option(
            names = "--plugins",
            paramLabel = "DIR",
            description =
                    "Folder of jars with actions, symbols, sensors and frame listeners in Java. Their"
                            + " code runs with all of your rights.")
    private Optional<Path> folder = Optional.empty();

    /**
     * Opens the plugins for this thread and the threads that it creates. Called before the command
     * reads a world. The plugins stay open until {@link #endUse}.
     *
     * @throws PluginException if a plugin cannot be used
     */
    void use() throws PluginException {
        if (folder.isPresent()) {
            Plugins plugins = Plugins.open(folder.get());
            Thread.currentThread().setContextClassLoader(plugins.contextLoader());
        }
    }

    /** Closes the plugins of this thread, if there are any. Called at the end of a command. */
    static void endUse(ClassLoader before) {
        Plugins.current().close();
        Thread.currentThread().setContextClassLoader(before);
    }
}
