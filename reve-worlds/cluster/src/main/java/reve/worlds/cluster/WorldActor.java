// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.actor.typed.Behavior;
import org.apache.pekko.actor.typed.PostStop;
import org.apache.pekko.actor.typed.javadsl.AbstractBehavior;
import org.apache.pekko.actor.typed.javadsl.ActorContext;
import org.apache.pekko.actor.typed.javadsl.Behaviors;
import org.apache.pekko.actor.typed.javadsl.Receive;
import org.jspecify.annotations.Nullable;

import reve.worlds.server.FrameFeed;
import reve.worlds.server.WorldHost;

import java.util.Optional;
import java.util.concurrent.TimeUnit;
import java.util.function.Consumer;

/**
 * One world of a cluster, on the node that runs it. Cluster sharding creates the actor when the
 * first {@link WorldCommand.Wake} reaches the node, and sends {@link WorldCommand.Stop} before it
 * places the world elsewhere. The world itself runs on a separate thread.
 */
final class WorldActor extends AbstractBehavior<WorldCommand> {
    /**
     * Time after which a world that could not be opened, or has ended, is opened again [ns]. The
     * time is long, because an operator may have to remove the reason, for example a law that this
     * node may not open.
     */
    private static final long RETRY_NANOSECONDS = TimeUnit.SECONDS.toNanos(30);

    private final Opener opener;
    private final Consumer<WorldHost.Hosting> handOver;
    private WorldHost.@Nullable Hosting hosting;
    private boolean stops;
    private boolean hasFailed;
    private long failedNanos;

    /** A function that opens the world of an actor. */
    interface Opener {
        /**
         * Opens the world.
         *
         * @param whenClosed is called on any thread when the world was closed; the argument is the
         *     reason, and is empty if the world was stopped
         */
        WorldHost.Hosting open(Consumer<Optional<String>> whenClosed);
    }

    private WorldActor(
            ActorContext<WorldCommand> context,
            Opener opener,
            Consumer<WorldHost.Hosting> handOver) {
        super(context);
        this.opener = opener;
        this.handOver = handOver;
    }

    /**
     * @param handOver closes the world for another node, when the world can be continued there;
     *     returns at once
     */
    static Behavior<WorldCommand> of(Opener opener, Consumer<WorldHost.Hosting> handOver) {
        return Behaviors.setup(context -> new WorldActor(context, opener, handOver));
    }

    @Override
    public Receive<WorldCommand> createReceive() {
        return newReceiveBuilder()
                .onMessage(WorldCommand.Wake.class, _ -> wake())
                .onMessage(WorldCommand.Watch.class, this::watch)
                .onMessage(WorldCommand.Stop.class, _ -> stop())
                .onMessage(WorldCommand.Closed.class, this::closed)
                .onSignal(PostStop.class, _ -> stopped())
                .build();
    }

    private Behavior<WorldCommand> wake() {
        boolean waits = hasFailed && System.nanoTime() - failedNanos < RETRY_NANOSECONDS;
        if (hosting == null && !stops && !waits) {
            var self = getContext().getSelf();
            try {
                hosting = opener.open(reason -> self.tell(new WorldCommand.Closed(reason)));
            } catch (IllegalStateException stillClosing) {
                // The exception is ignored. Either this node only watches, or an earlier actor of
                // this
                // world has ended, but its world is not closed yet. The next message opens it then.
            }
        }
        return this;
    }

    private Behavior<WorldCommand> watch(WorldCommand.Watch watch) {
        Optional<FrameFeed> feed = hosting == null ? Optional.empty() : hosting.feed();
        String stream =
                feed.map(open -> FrameStream.offer(open, getContext().getSystem())).orElse("");
        watch.reader().tell(new FrameOffer(stream));
        return this;
    }

    private Behavior<WorldCommand> stop() {
        stops = true;
        if (hosting == null) {
            return Behaviors.stopped();
        }
        handOver.accept(hosting);
        return this;
    }

    private Behavior<WorldCommand> closed(WorldCommand.Closed closed) {
        hosting = null;
        hasFailed = closed.reason().isPresent();
        failedNanos = System.nanoTime();
        return stops ? Behaviors.stopped() : this;
    }

    /** Closes the world if the actor ends without a message. This happens when the node ends. */
    private Behavior<WorldCommand> stopped() {
        if (hosting != null) {
            handOver.accept(hosting);
        }
        return this;
    }
}
