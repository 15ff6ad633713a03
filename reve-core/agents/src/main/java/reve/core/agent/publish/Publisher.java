// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import reve.core.agent.embodiment.Heard;
import reve.core.agent.embodiment.Rewound;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.perception.PerceptionShares;
import reve.core.agent.perception.Senses;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.Encoding;
import reve.core.frame.FrameEvent;
import reve.core.world.WorldEvent;
import reve.core.world.WorldSnapshot;

import java.util.ArrayList;
import java.util.BitSet;
import java.util.Collection;
import java.util.EnumSet;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.function.BooleanSupplier;
import java.util.function.LongSupplier;

/**
 * Sends the results, events and perceptions of a world's frames to its clients. The world's thread
 * only records data in this object, without a lock. The event loop does the work for all clients.
 */
public final class Publisher {

    /**
     * Maximum number of frames whose events wait to be sent. Events of further frames are lost. At
     * 60 frames per second, this limit corresponds to 17 s.
     */
    private static final int MAX_EVENT_FRAMES = 1024;

    /**
     * Time per frame for sending events about acts to clients in real time [ns]. Further events
     * about acts are dropped for these clients after this time.
     */
    private static final long ACTS_NANOS = 5_000_000;

    /**
     * Time for one session's view before the event loop does other work [ns]. A view that needs
     * more time is continued in a later slice. See {@link LongViews}.
     */
    private static final long LOOK_NANOS = 10_000_000;

    /** Time for encoding new items before the event loop does other work [ns]. */
    private static final long ENCODE_NANOS = 5_000_000;

    /**
     * Number of events per frame that are sent even if sending takes longer than {@link
     * #ACTS_NANOS}. A world with few clients therefore drops no event, even on a busy machine.
     */
    private static final long FEWEST_SENT = 1000;

    /**
     * Maximum number of boxes that searches for lines of sight examine for the events of a frame,
     * which takes about 2 ms. For further events, the last view of a client with such a sensor
     * decides whether it receives the event, unless the client is in lock-step.
     */
    private static final long MOST_EXAMINED = 100_000;

    private static final String ACTED = "acted";

    /** Type of the event that reports what an agent says. Agents receive {@link Heard} instead. */
    private static final String SPOKE = "spoke";

    /** Types of the events which report that an agent in lock-step is late, away or back. */
    private static final Set<String> ABSENCES = Set.of("late", "away", "back");

    /**
     * Maximum number of events per frame which report to a client that other agents in lock-step
     * are late, away or back.
     */
    public static final int MAX_ABSENCES = 8;

    private final WorldPort port;
    private final RateLimitedLog log;
    private final Runnable afterFrame;
    private final PerceptionEncoder encoder = new PerceptionEncoder();
    private final LongSupplier clock;
    private final PerceptionShares<Perceiver> shares;
    private final Queue<Runnable> reports = new ConcurrentLinkedQueue<>();
    private final Queue<Perceiver> leavers = new ConcurrentLinkedQueue<>();
    private final Queue<Happened> events = new ConcurrentLinkedQueue<>();
    private final AtomicInteger eventFrames = new AtomicInteger();
    private final AtomicInteger lostEventFrames = new AtomicInteger();
    private final Map<String, Perceiver> members = new LinkedHashMap<>();
    private final EventRouting routing = new EventRouting();
    private final FrameViews views;
    private final LongViews longViews;
    private final Runnable wake;

    /** True if sessions still wait for their perception of the frame that was served last. */
    private boolean owesPerceptions;

    /** True if the frame that was read last is not served yet, because its items are encoded. */
    private boolean isEncoding;

    private volatile long published;
    private volatile boolean news;
    private long served;

    /** Number of examined boxes at which the events of a frame end their searches. */
    private long sightEnd;

    /** The members that did not receive an event, because there was no search for its items. */
    private final List<Perceiver> unsearched = new ArrayList<>();

    /** The events of one frame, and the utterances that agents hear in it. */
    private record Happened(long frame, List<WorldEvent> events, List<Heard> heard) {}

    /**
     * @param afterFrame run on the event loop after the data of each frame was sent
     * @param wake wakes the event loop
     */
    public Publisher(WorldPort port, RateLimitedLog log, Runnable afterFrame, Runnable wake) {
        this(port, log, afterFrame, wake, System::nanoTime);
    }

    /**
     * @param clock the time by which the publisher divides the event loop's time [ns]
     */
    public Publisher(
            WorldPort port,
            RateLimitedLog log,
            Runnable afterFrame,
            Runnable wake,
            LongSupplier clock) {
        this.port = port;
        this.clock = clock;
        this.shares = new PerceptionShares<>(clock.getAsLong());
        this.views = new FrameViews(routing, port.snapshots().prototype(), clock);
        this.longViews = new LongViews(routing, port.snapshots().prototype(), clock);
        this.published = port.loop().frame(); // a world of a store has made frames before
        this.log = log;
        this.afterFrame = afterFrame;
        this.wake = wake;
    }

    // ---- methods for the world's thread ----

    /**
     * Records the events of a frame for the event loop, in the phase PUBLISH.
     *
     * @param heard the utterances that agents hear in the frame
     */
    public void onFrame(FrameEvent event, List<Heard> heard) {
        List<WorldEvent> happened = event.world().events();
        if (!happened.isEmpty() || !heard.isEmpty()) {
            if (eventFrames.incrementAndGet() <= MAX_EVENT_FRAMES) {
                events.add(new Happened(event.frame(), happened, heard));
            } else {
                eventFrames.decrementAndGet();
                lostEventFrames.incrementAndGet();
            }
        }
        published = event.frame();
        bring();
    }

    // ---- methods for any thread ----

    /** Runs code that sends a result on the event loop, before the next perceptions. */
    public void later(Runnable report) {
        reports.add(report);
        bring();
    }

    private void bring() {
        news = true;
        wake.run();
    }

    /**
     * Returns whether there is data to send, or sessions wait for perceptions. For the event loop's
     * thread only.
     */
    public boolean hasWork() {
        return news || owesPerceptions;
    }

    /** Removes a session; nothing more is sent to it. */
    public void dismiss(Perceiver session) {
        leavers.add(session);
    }

    /**
     * Runs code that sends a result together with the frame that is being made. Called in the phase
     * ACT.
     */
    public void withFrame(Runnable report) {
        reports.add(report);
    }

    /** Returns the number of the last published frame. */
    public long published() {
        return published;
    }

    // ---- methods for the event loop's thread ----

    /** Returns the encoder of perceptions. */
    public PerceptionEncoder encoder() {
        return encoder;
    }

    /** Returns the shares of the sessions in the event loop's time for perceptions. */
    public PerceptionShares<Perceiver> shares() {
        return shares;
    }

    /** Adds a session, which receives events from now on. */
    public void admit(Perceiver session) {
        members.put(session.name(), session);
    }

    /**
     * Handles a rewind of the world: assigns the bodies, which may have changed, and restarts all
     * streams of perceptions.
     */
    public void tellRewound(Rewound rewound) {
        isEncoding = false; // the newest frame is served next
        for (Perceiver member : members.values()) {
            Optional.ofNullable(rewound.bodies().get(member.name())).ifPresent(member::embodied);
            member.perceptions().restart(rewound.frame());
        }
    }

    /**
     * Sends all results, events and perceptions up to the last published frame, even if this takes
     * several turns. For a world that ends.
     */
    public void tellAll() {
        long last = published;
        do {
            tell();
        } while (isEncoding || news && served < last);
    }

    /** Sends the available results, events and perceptions. */
    public void tell() {
        news = false;
        try {
            publish();
        } catch (Throwable e) { // an error must not stop the sending of data to all agents
            isEncoding = false;
            log.error("telling agents about frame " + published + " failed", e);
        }
    }

    private void publish() {
        dropWhoHasLeft();
        // The order of these steps matters. A client receives the events of a frame before its
        // perception of that frame. A client that joins in a frame receives the events of that
        // frame. Events wait for the snapshot of their frame, because the snapshot shows which
        // clients perceive their items.
        Optional<WorldSnapshot> snapshot = unservedSnapshot();
        try {
            for (Runnable report = reports.poll(); report != null; report = reports.poll()) {
                report.run();
            }
            boolean waited = isEncoding;
            boolean wanted =
                    waited
                            || snapshot.filter(frame -> isWanted(frame, !events.isEmpty()))
                                    .isPresent();
            boolean isRead =
                    waited
                            || owesPerceptions
                                    && snapshot.filter(frame -> frame.frame() == served)
                                            .isPresent();
            owesPerceptions = false;
            if (wanted && !isRead && !views.observatory().read(snapshot.get())) {
                // The snapshot was overwritten while it was read, so the next frame is available.
                return;
            }
            isEncoding = wanted && !encode();
            if (isEncoding) {
                // Newer frames wait, because all their items may be new, too.
                if (!waited) {
                    longViews.hold(snapshot.get());
                }
                owesPerceptions = true;
                return;
            }
            if (waited) {
                news = true; // newer frames may have come meanwhile
            }
            served = wanted ? views.frame() : snapshot.map(WorldSnapshot::frame).orElse(served);
            tellEvents();
            if (wanted) {
                serve(snapshot.filter(frame -> frame.frame() == served));
            }
        } finally {
            snapshot.ifPresent(WorldSnapshot::close);
        }
        afterFrame.run();
    }

    /** Encodes new items; returns false if the event loop must do other work first. */
    private boolean encode() {
        var encodings = EnumSet.noneOf(Encoding.class);
        for (Perceiver member : members.values()) {
            if (!member.hasSensors()) { // sensors select what is encoded
                encodings.add(member.encoding());
            }
        }
        long begin = clock.getAsLong();
        return views.observatory()
                .encode(encodings, () -> clock.getAsLong() - begin < ENCODE_NANOS);
    }

    private void dropWhoHasLeft() {
        for (Perceiver gone = leavers.poll(); gone != null; gone = leavers.poll()) {
            members.remove(gone.name(), gone); // does not remove a newer client of the same name
            routing.forget(gone);
            longViews.forget(gone);
        }
    }

    private Optional<WorldSnapshot> unservedSnapshot() {
        if (published == served && !owesPerceptions) {
            return Optional.empty();
        }
        Optional<WorldSnapshot> latest = port.snapshots().acquireLatest();
        if (latest.isPresent() && latest.get().frame() > published) {
            // The events of this frame are not recorded yet. The loop is woken again when they are.
            latest.get().close();
            return Optional.empty();
        }
        return latest;
    }

    /**
     * Sends the events of all frames up to the frame that is being served. The world recorded these
     * events before it made the snapshot.
     */
    private void tellEvents() {
        int lost = lostEventFrames.getAndSet(0);
        if (lost > 0) {
            log.warn(
                    "agents will not be sent the events of "
                            + lost
                            + " frames: too many were waiting");
        }
        if (events.isEmpty()) {
            return;
        }
        routing.locate(members.values(), views.observatory());
        long end = clock.getAsLong() + ACTS_NANOS;
        sightEnd = views.observatory().examined() + MOST_EXAMINED;
        var acts = new Gap();
        var absences = new Gap();
        var own = new HashMap<Perceiver, Integer>();
        var unseen = new HashMap<Perceiver, Gap>();
        long sent = 0;
        for (Happened next = events.peek();
                next != null && next.frame <= served;
                next = events.peek()) {
            events.remove();
            eventFrames.decrementAndGet();
            int absent = 0;
            for (WorldEvent event : next.events) {
                boolean isLate = sent >= FEWEST_SENT && clock.getAsLong() - end > 0;
                if (event.type().equals(ACTED) && (acts.count > 0 || isLate)) {
                    tell(event, false);
                    acts.add(next.frame);
                } else if (isAbsence(event) && (absent++ >= MAX_ABSENCES || isLate)) {
                    tellAgent(event).ifPresent(agent -> own.merge(agent, 1, Integer::sum));
                    absences.add(next.frame);
                } else {
                    tell(event, true);
                    sent += members.size();
                }
            }
            for (Perceiver member : unsearched) {
                unseen.computeIfAbsent(member, unknown -> new Gap()).add(next.frame);
            }
            unsearched.clear();
            next.heard.forEach(this::tell);
            sent += next.heard.size();
        }
        if (acts.count + absences.count > 0 || !unseen.isEmpty()) {
            for (Perceiver member : members.values()) {
                Gap gap = member.isInLockStep() ? absences : acts.with(absences);
                gap = gap.with(unseen.getOrDefault(member, Gap.NONE));
                long count = gap.count - own.getOrDefault(member, 0);
                if (count > 0) {
                    member.miss(count, gap.first, gap.last);
                }
            }
        }
    }

    /**
     * The events that were not sent to clients: their number, and the first and last of their
     * frames.
     */
    private static final class Gap {
        private static final Gap NONE = new Gap();

        private long count;
        private long first = Long.MAX_VALUE;
        private long last;

        void add(long frame) {
            count++;
            first = Math.min(first, frame);
            last = Math.max(last, frame);
        }

        Gap with(Gap other) {
            var both = new Gap();
            both.count = count + other.count;
            both.first = Math.min(first, other.first);
            both.last = Math.max(last, other.last);
            return both;
        }
    }

    /**
     * Returns whether the frame must be read. The result is true if a client needs a perception. It
     * is also true if there are new events, because the frame determines which clients receive
     * them.
     */
    private boolean isWanted(WorldSnapshot snapshot, boolean news) {
        long frame = snapshot.frame();
        for (Perceiver member : members.values()) {
            if (member.perceptions().isDue(frame) || news && member.hasSensors()) {
                return true;
            }
        }
        return false;
    }

    /**
     * Sends an event to the clients that perceive its items.
     *
     * @param all true if all clients may receive the event, false if only clients in lock-step
     */
    private void tell(WorldEvent event, boolean all) {
        if (!all && !routing.hasLockStep()) {
            return;
        }
        EventSubjects subjects = EventSubjects.in(event, views.observatory(), this::bodyOf);
        var heard = new HeardEvent(event);
        if (event.type().equals(SPOKE)) {
            for (Perceiver member : routing.withoutSensors()) {
                if (member.body().isEmpty()) {
                    tell(member, subjects, heard);
                }
            }
            return;
        }
        tell(routing.withoutSensors(), all, subjects, heard);
        tell(routing.of(subjects, views.observatory()), all, subjects, heard);
    }

    /** Sends an agent an utterance that it hears. */
    private void tell(Heard heard) {
        Perceiver hearer = members.get(heard.hearer());
        if (hearer != null && hearer.body().isPresent()) {
            hearer.tell(HeardEvent.Told.of(heard.event(), hearer.encoding()));
        }
    }

    /**
     * Returns whether the server itself raised the event to report an absent agent. Listeners in
     * Java may raise events of the same types, but with other fields.
     */
    private static boolean isAbsence(WorldEvent event) {
        return ABSENCES.contains(event.type())
                && event.fields().containsKey(EventSubjects.AGENT)
                && event.fields().containsKey("body");
    }

    /**
     * Sends an event to the agent that its field {@code agent} names.
     *
     * @return the agent, if the event was sent
     */
    private Optional<Perceiver> tellAgent(WorldEvent event) {
        Perceiver agent = members.get(String.valueOf(event.fields().get(EventSubjects.AGENT)));
        if (agent == null) {
            return Optional.empty();
        }
        EventSubjects subjects = EventSubjects.in(event, views.observatory(), this::bodyOf);
        return tell(agent, subjects, new HeardEvent(event)) ? Optional.of(agent) : Optional.empty();
    }

    private void tell(
            Collection<Perceiver> hearers, boolean all, EventSubjects subjects, HeardEvent heard) {
        for (Perceiver member : hearers) {
            if (!all && !member.isInLockStep()) {
                continue;
            }
            tell(member, subjects, heard);
        }
    }

    /**
     * Sends an event to a member that perceives its items.
     *
     * @return false if the event is not sent, because the member does not perceive its items
     */
    private boolean tell(Perceiver member, EventSubjects subjects, HeardEvent heard) {
        Observatory world = views.observatory();
        boolean searches =
                world.examined() < sightEnd || member.isInLockStep() || !member.needsSight();
        Optional<BitSet> fields = member.hear(heard.event(), subjects, world, searches);
        if (!searches && fields.isEmpty() && !Senses.FOR_OPERATORS.contains(heard.event().type())) {
            unsearched.add(member);
        }
        fields.ifPresent(told -> member.tell(heard.with(told, member.encoding())));
        return fields.isPresent();
    }

    private Optional<String> bodyOf(String agent) {
        return Optional.ofNullable(members.get(agent)).flatMap(Perceiver::body);
    }

    private void serve(Optional<WorldSnapshot> newest) {
        encoder.begin(views.observatory().everything());
        views.beginSlice(member -> members.get(member.name()) == member);
        shares.begin(members.values(), views.frame(), clock.getAsLong());
        boolean isCut = false;
        for (Perceiver member : members.values()) {
            if (!member.perceptions().isDue(views.frame())) {
                continue;
            }
            if (longViews.contains(member)) {
                shares.postpone(member);
            } else if (shares.isServedNow(member)) {
                if (isCut && member.isInLockStep() && member.hasSensors()) {
                    // A slice computes at most one view whose duration is unknown.
                    owesPerceptions = true;
                } else {
                    serve(member, newest);
                    isCut |= longViews.contains(member);
                }
            }
        }
        for (Perceiver member : shares.waiting()) {
            if (isCut || !shares.isTimeLeft()) {
                owesPerceptions = true;
                return;
            }
            boolean wasLong = longViews.contains(member);
            serve(member, newest);
            isCut = longViews.contains(member) && !wasLong;
        }
    }

    private void serve(Perceiver member, Optional<WorldSnapshot> newest) {
        long begin = clock.getAsLong();
        BooleanSupplier isTimeLeft = () -> clock.getAsLong() - begin < LOOK_NANOS;
        boolean served;
        if (longViews.contains(member)) {
            served = longViews.serve(member, views.frame(), newest, isTimeLeft);
        } else {
            served = views.serve(member, isTimeLeft);
            if (views.isCut()) {
                longViews.add(member);
            }
        }
        long nanos = clock.getAsLong() - begin;
        if (served) {
            shares.serve(member.perceptionCost(), nanos);
        } else {
            shares.spend(member.perceptionCost(), nanos);
        }
        // A client with a long view may have received a view of an earlier frame. That client still
        // waits for this frame.
        owesPerceptions |= !served || member.perceptions().isDue(views.frame());
    }
}
