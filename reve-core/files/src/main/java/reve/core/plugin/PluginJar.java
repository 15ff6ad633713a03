// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import reve.core.access.ActionProvider;
import reve.core.frame.FrameListenerProvider;
import reve.core.world.SensorProvider;
import reve.core.world.SymbolProvider;

import java.net.URLClassLoader;
import java.util.List;

/**
 * An opened plugin with its providers, in the order of its files in {@code META-INF/services}.
 *
 * @param loader the class loader of the plugin, which has the name of the jar's file
 */
record PluginJar(
        PluginInfo info,
        URLClassLoader loader,
        List<ActionProvider> actions,
        List<SymbolProvider> symbols,
        List<SensorProvider> sensors,
        List<FrameListenerProvider> listeners) {

    boolean isEmpty() {
        return actions.isEmpty() && symbols.isEmpty() && sensors.isEmpty() && listeners.isEmpty();
    }
}
