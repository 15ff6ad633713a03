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
 * Views with relations. The relations of a frame are computed in slices of time; between slices the
 * event loop serves other sessions and newer frames. A session in real time whose relations need
 * more than one slice receives the view of the requested frame later, with the relations of that
 * frame. A session in lock-step receives its view at once, because the world waits for it. See
 * docs/decisions/0006. The event loop's thread.
 *
 * @param <C> a client
 */
public final class RelatedViews<C extends RelatedViews.Client> {

    /** Maximum time for relations before other sessions are served [ns]. */
    private static final long SLICE_NANOS = 10_000_000;

    private final LongSupplier clock;
    private final FrameRelations relations = new FrameRelations();

    /** Requested views of the frame whose relations are being computed. */
    private final Map<C, Wanted> waiting = new IdentityHashMap<>();

    private long until;

    /** A client with perceptions. */
    public interface Client {
        /** Returns whether the world waits for the client. */
        boolean isInLockStep();

        /** Returns whether the client's perception of a frame has relations. */
        boolean wantsRelations(long frame);

        /** See {@link Senses#sensedIn}. */
        Optional<Set<ItemId>> sensedIn(long frame);

        /**
         * Keeps the older relations of items that were not sensed again, see {@link Senses#relate}.
         */
        View relate(View view, Optional<Set<ItemId>> fresh);
    }

    /**
     * @param fresh items that were sensed in the frame of the view; empty if all were
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
     * @param isThere false for sessions that have left
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
     * @return empty if the slice was too short; a later call continues
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
                    return Optional.empty(); // sessions that wait for the previous frame come first
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
