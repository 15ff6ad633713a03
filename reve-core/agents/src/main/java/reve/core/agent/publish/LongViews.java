// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import org.jspecify.annotations.Nullable;

import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.IdentityHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.function.BooleanSupplier;
import java.util.function.LongSupplier;

/**
 * The clients whose views need more than one slice of the event loop's time. Their views are
 * computed one after the other, in a separate copy of the frame. Meanwhile the other clients
 * receive newer frames between the slices. See docs/decisions/0006. For the event loop's thread
 * only.
 */
final class LongViews {

    /**
     * Number of views in sequence that must each fit in one slice. After this number, the client is
     * served like the other clients again.
     */
    private static final int SHORT_VIEWS = 10;

    private final EventRouting routing;
    private final WorldPrototype prototype;
    private final LongSupplier clock;

    /**
     * The clients with long views. The value is the number of their last views that needed only one
     * slice each.
     */
    private final Map<Perceiver, Integer> shortViews = new IdentityHashMap<>();

    /** The client whose view of the copied frame is not complete yet; null if there is none. */
    private @Nullable Perceiver looking;

    /** The views of the copied frame; null while no client has long views. */
    private @Nullable FrameViews views;

    /**
     * @param routing receives the views
     * @param prototype the prototype of the world
     * @param clock the time of the event loop [ns]
     */
    LongViews(EventRouting routing, WorldPrototype prototype, LongSupplier clock) {
        this.routing = routing;
        this.clock = clock;
        this.prototype = prototype;
    }

    /** Records that the view of a client needs more than one slice. */
    void add(Perceiver member) {
        shortViews.put(member, 0);
    }

    boolean contains(Perceiver member) {
        return shortViews.containsKey(member);
    }

    /** Removes a client that has left. */
    void forget(Perceiver member) {
        shortViews.remove(member);
        if (looking == member) {
            looking = null;
        }
        if (shortViews.isEmpty()) {
            views = null;
        }
    }

    /** Copies a frame that is served in a later turn, so that a view of it can begin then. */
    void hold(WorldSnapshot snapshot) {
        if (!shortViews.isEmpty() && looking == null) {
            read(copy(), snapshot.frame(), Optional.of(snapshot));
        }
    }

    private FrameViews copy() {
        FrameViews copy = views;
        if (copy == null) {
            copy = new FrameViews(routing, prototype, clock);
            views = copy;
        }
        return copy;
    }

    /**
     * Continues the unfinished view of a client, or begins a view of the newest frame.
     *
     * @param frame number of the frame that is served
     * @param newest its snapshot; empty if it cannot be read now
     * @param isTimeLeft false at the end of the slice
     * @return false if a view is not computed yet
     */
    boolean serve(
            Perceiver member,
            long frame,
            Optional<WorldSnapshot> newest,
            BooleanSupplier isTimeLeft) {
        FrameViews copy = copy();
        Perceiver before = looking;
        if (before != null && !before.perceptions().isDue(copy.frame())) {
            looking = null; // this client's requests have changed
        }
        boolean isContinued = looking == member;
        if (!isContinued && (looking != null || !read(copy, frame, newest))) {
            return false;
        }
        copy.beginSlice(this::contains);
        boolean served = copy.serve(member, isTimeLeft);
        looking = served ? null : member;
        if (served) {
            count(member, !isContinued);
        }
        return served;
    }

    private static boolean read(FrameViews copy, long frame, Optional<WorldSnapshot> newest) {
        return copy.frame() == frame || newest.isPresent() && copy.observatory().read(newest.get());
    }

    private void count(Perceiver member, boolean isShort) {
        int successive = isShort ? shortViews.getOrDefault(member, 0) + 1 : 0;
        if (successive < SHORT_VIEWS) {
            shortViews.put(member, successive);
        } else {
            forget(member);
        }
    }
}
