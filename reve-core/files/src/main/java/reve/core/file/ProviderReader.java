// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.access.ActionProvider;
import reve.core.plugin.Plugins;
import reve.core.world.SensorProvider;
import reve.core.world.SymbolProvider;

import java.util.List;
import java.util.Optional;
import java.util.ServiceConfigurationError;
import java.util.function.Function;
import java.util.function.Supplier;

/** Finder of the providers in Java that world files name with the key {@code java}. */
final class ProviderReader {
    static final String JAVA = "java";

    private final Problems problems;
    private final Plugins plugins = Plugins.current();

    ProviderReader(Problems problems) {
        this.problems = problems;
    }

    /**
     * Returns the action that a node names. Records a problem and returns empty if there is none.
     */
    Optional<ActionProvider> action(Node java) {
        return find(java, "action", plugins::actions, ActionProvider::name);
    }

    /** Returns the provider of a symbol that a node names, like {@link #action}. */
    Optional<SymbolProvider> symbol(Node java) {
        return find(java, "symbol", plugins::symbols, SymbolProvider::name);
    }

    /** Returns the provider of a sensor that a node names, like {@link #action}. */
    Optional<SensorProvider> sensor(Node java) {
        return find(java, "sensor", plugins::sensors, SensorProvider::name);
    }

    private <T> Optional<T> find(
            Node java, String what, Supplier<List<T>> all, Function<T, String> nameOf) {
        Optional<String> name = java.text();
        if (name.isEmpty()) {
            return Optional.empty(); // the schema check has reported it
        }
        List<T> providers;
        try {
            providers = all.get();
        } catch (ServiceConfigurationError broken) {
            problems.add(
                    java, "java: the class path has a broken provider: " + broken.getMessage());
            return Optional.empty();
        }
        Optional<T> found =
                providers.stream()
                        .filter(each -> nameOf.apply(each).equals(name.get()))
                        .findFirst();
        if (found.isEmpty()) {
            List<String> names = providers.stream().map(nameOf).sorted().toList();
            String known =
                    names.isEmpty()
                            ? "no plugin has any; name the folder of the plugin with --plugins"
                            : "the plugins have " + String.join(", ", names);
            problems.add(
                    java,
                    "java: there is no "
                            + what
                            + " `"
                            + Node.shorten(name.get())
                            + "`; "
                            + known
                            + problems.suggestion(name.get(), names));
        }
        return found;
    }
}
