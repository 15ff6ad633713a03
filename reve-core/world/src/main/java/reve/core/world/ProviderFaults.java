// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Set;

/**
 * Reporter of failures in the code of providers, such as actions, symbols, sensors and listeners of
 * plugins. It reports the first failure of each provider in a world: with its place to the log, and
 * as an event {@code fault}. For the world's thread only.
 */
public final class ProviderFaults {
    private static final Logger LOG = LoggerFactory.getLogger("plugins");

    /** Maximum number of providers whose failures a world reports. */
    private static final int MAX_REPORTED = 1000;

    /** Maximum length of the reported message of a failure [characters]. */
    private static final int MAX_MESSAGE = 1000;

    /** Name of the JVM's class loader for the class path. */
    private static final String CLASS_PATH_LOADER = "app";

    private final String world;
    private final WorldGuard guard;
    private final FrameRecord record;
    private final Set<String> reported = new HashSet<>();

    private boolean isListening;

    ProviderFaults(String world, WorldGuard guard, FrameRecord record) {
        this.world = world;
        this.guard = guard;
        this.record = record;
    }

    /**
     * Reports a failure, unless this world has reported one of the same source before.
     *
     * @param frame number of the frame
     * @param phase phase of the frame
     * @param source what failed, for example {@code listener example.counter}
     * @param provider the object whose code failed; its class is named in the report
     * @param consequence what the failure causes, as the end of a message
     */
    public void report(
            long frame,
            String phase,
            String source,
            Object provider,
            Throwable failure,
            String consequence) {
        guard.checkOwner();
        if (reported.size() >= MAX_REPORTED || !reported.add(source)) {
            return;
        }
        String plugin = pluginOf(provider);
        String type = provider.getClass().getName();
        LOG.error(
                "world {}, frame {} {}: {} failed (class {} of {}); {}",
                world,
                frame,
                phase,
                source,
                type,
                plugin,
                consequence,
                failure);
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("phase", phase);
        fields.put("source", source);
        fields.put("plugin", plugin);
        fields.put("class", type);
        fields.put("error", failure.getClass().getSimpleName());
        fields.put("message", shortened(failure.getMessage()) + "; " + consequence);
        record.raise(new WorldEvent(frame, "fault", fields));
    }

    private static String shortened(@Nullable String message) {
        return message == null || message.length() <= MAX_MESSAGE
                ? String.valueOf(message)
                : message.substring(0, MAX_MESSAGE) + "…";
    }

    /**
     * States whether a listener of a provider runs. While it runs, {@link World#raise} refuses
     * events of the types that the server raises itself. For the world's thread only.
     */
    public void setListening(boolean runs) {
        isListening = runs;
    }

    /** Refuses an event that only the server may raise, while a listener of a provider runs. */
    void requireOwn(WorldEvent event) {
        if (isListening && WorldEvent.OF_THE_SERVER.contains(event.type())) {
            throw new IllegalArgumentException(
                    "a listener must not raise the event "
                            + event.type()
                            + ", which the server raises itself; use another type");
        }
    }

    /**
     * Throws errors after which the Java virtual machine cannot be trusted. A provider must not
     * hide them. All other errors of a provider cost only the call.
     */
    public static void requireBearable(Throwable failure) {
        if (failure instanceof VirtualMachineError fatal
                && !(failure instanceof StackOverflowError)) {
            throw fatal;
        }
    }

    /**
     * Clears the interrupt of the thread. A provider may leave it set, and the world's thread would
     * then end its world.
     */
    public static void clearInterrupt() {
        Thread.interrupted();
    }

    /**
     * Returns the file name of the plugin that contains the class of a provider, or {@code the
     * class path}. The class loader of a plugin has the name of the plugin's file. For any thread.
     */
    public static String pluginOf(Object provider) {
        ClassLoader loader = provider.getClass().getClassLoader();
        String name = loader == null ? null : loader.getName();
        return name == null || name.equals(CLASS_PATH_LOADER) ? "the class path" : name;
    }
}
