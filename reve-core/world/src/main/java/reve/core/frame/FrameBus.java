// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Arrays;
import java.util.concurrent.atomic.AtomicReferenceArray;

/**
 * The bus that notifies listeners of the phases of each frame, in order of subscription. Any thread
 * may add and end subscriptions. Listeners are called on the world's thread.
 */
public final class FrameBus {

    private static final Subscriber[] NONE = {};

    /**
     * Subscribers by phase. A new subscription replaces the array of its phase, so that a dispatch
     * needs no lock.
     */
    private final AtomicReferenceArray<Subscriber[]> subscribers =
            new AtomicReferenceArray<>(FramePhase.values().length);

    private final FaultLog faults = new FaultLog();

    /** Creates a bus without subscribers. */
    public FrameBus() {
        for (int i = 0; i < subscribers.length(); i++) {
            subscribers.set(i, NONE);
        }
    }

    /**
     * Adds a listener. The bus calls it from the next dispatch of its phase on.
     *
     * @param name name of the listener, for messages
     * @throws IllegalStateException if the phase is PHYSICS and already has a listener
     */
    public synchronized Subscription subscribe(
            FramePhase phase, String name, FrameListener listener) {
        Subscriber[] old = subscribers.get(phase.ordinal());
        if (phase == FramePhase.PHYSICS && old.length > 0) {
            throw new IllegalStateException(
                    "PHYSICS takes one listener and has "
                            + old[0].name
                            + "; close that before subscribing "
                            + name);
        }
        var subscriber = new Subscriber(name, listener);
        Subscriber[] grown = Arrays.copyOf(old, old.length + 1);
        grown[old.length] = subscriber;
        subscribers.set(phase.ordinal(), grown);
        return () -> unsubscribe(phase, subscriber);
    }

    /**
     * Calls the listeners of the event's phase. An exception of one listener does not prevent the
     * calls of the others. Each distinct exception message raises one "fault" event.
     */
    void dispatch(FrameEvent event) {
        for (Subscriber subscriber : subscribers.get(event.phase().ordinal())) {
            try {
                subscriber.listener.onFrame(event);
            } catch (Exception | LinkageError | StackOverflowError e) {
                faults.report(event, subscriber.name, e);
            }
        }
    }

    private synchronized void unsubscribe(FramePhase phase, Subscriber subscriber) {
        Subscriber[] remaining =
                Arrays.stream(subscribers.get(phase.ordinal()))
                        .filter(other -> other != subscriber)
                        .toArray(Subscriber[]::new);
        subscribers.set(phase.ordinal(), remaining);
    }

    private record Subscriber(String name, FrameListener listener) {}
}
