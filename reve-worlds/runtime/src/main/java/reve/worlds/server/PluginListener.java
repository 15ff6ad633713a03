// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.frame.FrameListenerProvider;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;
import reve.core.world.ProviderFaults;
import reve.core.world.World;

/**
 * A frame listener of a plugin in one world. The first exception that it throws ends its
 * subscription. For the world's thread only.
 */
final class PluginListener implements FrameListener {
    private final FrameListenerProvider provider;
    private final FrameListener listener;
    private final String source;
    private @Nullable Subscription subscription;

    private PluginListener(FrameListenerProvider provider, FrameListener listener, String source) {
        this.provider = provider;
        this.listener = listener;
        this.source = source;
    }

    /**
     * Creates the listener for a world and subscribes it to ACT. A provider that fails adds no
     * listener, and is reported.
     *
     * @param frame number of the last frame
     */
    static void subscribe(World world, long frame, FrameBus bus, FrameListenerProvider provider) {
        String source = "listener " + provider.name();
        try {
            FrameListener made = provider.listen(world);
            if (made == null) {
                throw new IllegalStateException("it returned null, expected a listener");
            }
            PluginListener listener = new PluginListener(provider, made, source);
            listener.subscription = bus.subscribe(FramePhase.ACT, source, listener);
        } catch (Throwable failure) {
            ProviderFaults.requireBearable(failure);
            report(world, frame + 1, source, provider, failure);
        } finally {
            ProviderFaults.clearInterrupt();
        }
    }

    @Override
    public void onFrame(FrameEvent event) {
        World world = event.world();
        world.activity().begin(source);
        try {
            world.providerFaults().setListening(true);
            listener.onFrame(event);
        } catch (Throwable failure) {
            ProviderFaults.requireBearable(failure);
            if (subscription != null) {
                subscription.close();
            }
            report(world, event.frame(), source, provider, failure);
        } finally {
            world.providerFaults().setListening(false);
            ProviderFaults.clearInterrupt();
            world.activity().end();
        }
    }

    private static void report(
            World world,
            long frame,
            String source,
            FrameListenerProvider provider,
            Throwable failure) {
        world.providerFaults()
                .report(
                        frame,
                        FramePhase.ACT.name(),
                        source,
                        provider,
                        failure,
                        "it is not called any more");
    }
}
