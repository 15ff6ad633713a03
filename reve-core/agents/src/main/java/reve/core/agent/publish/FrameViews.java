// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import org.jspecify.annotations.Nullable;

import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.RelatedViews;
import reve.core.agent.perception.View;
import reve.core.world.WorldPrototype;

import java.util.Optional;
import java.util.concurrent.atomic.AtomicReference;
import java.util.function.BooleanSupplier;
import java.util.function.LongSupplier;
import java.util.function.Predicate;

/**
 * A copy of one frame, and the clients' views of it, with and without relations. For the event
 * loop's thread.
 */
final class FrameViews {

    private final Observatory observatory;
    private final RelatedViews<Perceiver> related;
    private final EventRouting routing;
    private boolean isCut;

    /**
     * @param routing receives the views of clients with sensors
     * @param prototype the prototype of the world
     * @param clock the time of the event loop [ns]
     */
    FrameViews(EventRouting routing, WorldPrototype prototype, LongSupplier clock) {
        related = new RelatedViews<>(clock);
        observatory = new Observatory(prototype);
        this.routing = routing;
    }

    /** Returns the frame that was read. */
    Observatory observatory() {
        return observatory;
    }

    long frame() {
        return observatory.everything().frame();
    }

    /**
     * Begins a slice of the event loop's time.
     *
     * @param isThere returns false for clients that have left
     */
    void beginSlice(Predicate<Perceiver> isThere) {
        related.begin(isThere);
    }

    /**
     * Serves the client's requests for perceptions of this frame.
     *
     * @param isTimeLeft false if the event loop must do other work first
     * @return false if a view is not computed yet; the next call in this frame continues
     */
    boolean serve(Perceiver member, BooleanSupplier isTimeLeft) {
        isCut = false;
        var known = new AtomicReference<@Nullable View>(); // two requests may share this view
        return member.perceptions()
                .serve(
                        frame(),
                        relations ->
                                relations
                                        ? relate(member, isTimeLeft, known)
                                        : look(member, isTimeLeft));
    }

    /** Returns whether the time was too short to complete a client's view. */
    boolean isCut() {
        return isCut;
    }

    private Optional<View> look(Perceiver member, BooleanSupplier isTimeLeft) {
        Optional<View> view = member.look(observatory, isTimeLeft);
        if (view.isEmpty()) {
            isCut = true;
        } else if (member.hasSensors()) {
            routing.shows(member, view.get());
        }
        return view;
    }

    private Optional<View> relate(
            Perceiver member, BooleanSupplier isTimeLeft, AtomicReference<@Nullable View> known) {
        View view = known.get();
        if (view == null) {
            view = related.of(member, () -> look(member, isTimeLeft), observatory).orElse(null);
            known.set(view);
        }
        return Optional.ofNullable(view);
    }
}
