// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.ItemId;

import java.util.IdentityHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.LongSupplier;
import java.util.function.Predicate;
import java.util.function.Supplier;

/**
 * Views that contain spatial relations. The relations of all items of a frame are computed in
 * slices of time. Between two slices the event loop serves other sessions and newer frames. The
 * relations of a session in real time may need more than one slice. The session then receives the
 * view of the requested frame later, with the relations of that frame. A session in lock-step
 * receives its view at once, because the world waits for it. See docs/decisions/0006. For the event
 * loop's thread only.
 *
 * @param <C> type of a client
 */
public final class RelatedViews<C extends RelatedViews.Client> {

    /**
     * Duration of a slice [ns]: the maximum time for relations before other sessions are served.
     */
    private static final long SLICE_NANOS = 10_000_000;

    private final LongSupplier clock;
    private final FrameRelations relations = new FrameRelations();

    /**
     * Views with relations for which sessions wait. All are of the frame whose relations are being
     * computed.
     */
    private final Map<C, Wanted> waiting = new IdentityHashMap<>();

    private long until;

    /** A client that receives perceptions. */
    public interface Client {
        /** Returns whether the client is in lock-step, which means that the world waits for it. */
        boolean isInLockStep();

        /** Returns whether the client has requested relations for its perception of a frame. */
        boolean wantsRelations(long frame);

        /** Returns the items whose symbols were sensed in a frame. See {@link Senses#sensedIn}. */
        Optional<Set<ItemId>> sensedIn(long frame);

        /**
         * Returns a view with relations. Items that were not sensed in the view's frame keep older
         * relations. See {@link Senses#relate}.
         */
        View relate(View view, Optional<Set<ItemId>> fresh);
    }

    /**
     * A view for which a session waits.
     *
     * @param fresh ids of the items that were sensed in the frame of the view; empty if all items
     *     were sensed in this frame
     */
    private record Wanted(View view, Optional<Set<ItemId>> fresh) {}

    /**
     * @param clock a clock like {@link System#nanoTime}
     */
    public RelatedViews(LongSupplier clock) {
        this.clock = clock;
    }

    /**
     * Begins a slice.
     *
     * @param isThere returns false for sessions that have left
     */
    public void begin(Predicate<C> isThere) {
        until = clock.getAsLong() + SLICE_NANOS;
        waiting.entrySet()
                .removeIf(
                        entry ->
                                !isThere.test(entry.getKey())
                                        || !entry.getKey()
                                                .wantsRelations(entry.getValue().view.frame()));
    }

    /**
     * Returns a session's view with relations.
     *
     * @param look returns the session's view of the newest frame; empty if the slice was too short
     * @return empty if the slice was too short; a call in a later slice continues the computation
     */
    public Optional<View> of(C member, Supplier<Optional<View>> look, Observatory world) {
        if (member.isInLockStep()) {
            if (!relations.isOf(world.everything())) {
                waiting.clear();
                world.begin(relations);
            }
            relations.complete();
            return look.get().map(view -> relate(member, wanted(member, view)));
        }
        Wanted wanted = waiting.get(member);
        if (wanted == null) {
            if (!relations.isOf(world.everything())) {
                if (!waiting.isEmpty()) {
                    // Other sessions wait for relations of an earlier frame. These relations are
                    // completed first.
                    return Optional.empty();
                }
                world.begin(relations);
            }
            Optional<View> view = look.get();
            if (view.isEmpty()) {
                return Optional.empty();
            }
            wanted = wanted(member, view.get());
            waiting.put(member, wanted);
        }
        if (!relations.advance(() -> clock.getAsLong() - until < 0)) {
            return Optional.empty();
        }
        waiting.remove(member);
        return Optional.of(relate(member, wanted));
    }

    private static Wanted wanted(Client member, View view) {
        return new Wanted(view, member.sensedIn(view.frame()));
    }

    private View relate(Client member, Wanted wanted) {
        return member.relate(relations.addTo(wanted.view), wanted.fresh);
    }
}
