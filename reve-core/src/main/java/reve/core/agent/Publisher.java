// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.frame.FrameEvent;
import reve.core.world.WorldEvent;
import reve.core.world.WorldSnapshot;

import java.util.BitSet;
import java.util.Collection;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;

/**
 * Tells agents what the frames brought: results, events, perceptions. The world's thread only
 * leaves word here, without a lock; the event loop does the work for all agents.
 */
final class Publisher {

    /** Frames with events that may wait to be told; at 60 frames a second a quarter of a minute. */
    private static final int MAX_EVENT_FRAMES = 1024;

    /** In so much time clients in real time are told of acts; those beyond they miss. */
    private static final long ACTS_NANOS = 5_000_000;

    private static final String ACTED = "acted";

    /** What agents in lock-step cause by doing nothing. */
    private static final Set<String> ABSENCES = Set.of("late", "away", "back");

    /** Most events of {@link #ABSENCES} in one frame that a client is sent about other agents. */
    static final int MAX_ABSENCES = 8;

    private final WorldPort port;
    private final RateLimitedLog log;
    private final Runnable afterFrame;
    private final Observatory observatory = new Observatory();
    private final Telling telling = new Telling();
    private final PerceptionShares<Session> shares = new PerceptionShares<>(System.nanoTime());
    private final Queue<Runnable> reports = new ConcurrentLinkedQueue<>();
    private final Queue<Session> leavers = new ConcurrentLinkedQueue<>();
    private final Queue<Happened> events = new ConcurrentLinkedQueue<>();
    private final AtomicInteger eventFrames = new AtomicInteger();
    private final AtomicInteger lostEventFrames = new AtomicInteger();
    private final Map<String, Session> members = new LinkedHashMap<>();
    private final Audience audience = new Audience();
    private final Runnable wake;

    /** Somebody waits for time to perceive the frame that was served. */
    private boolean owesPerceptions;

    private volatile long published;
    private volatile boolean news;
    private long served;

    /** The events of one frame. */
    private record Happened(long frame, List<WorldEvent> events) {}

    /**
     * @param afterFrame what else is to be done when a frame has passed, on the event loop
     * @param wake lets the event loop know that there is something to tell
     */
    Publisher(WorldPort port, RateLimitedLog log, Runnable afterFrame, Runnable wake) {
        this.port = port;
        this.log = log;
        this.afterFrame = afterFrame;
        this.wake = wake;
    }

    // ---- world's thread ----

    /** Listens to PUBLISH. */
    void onFrame(FrameEvent event) {
        List<WorldEvent> happened = event.world().events();
        if (!happened.isEmpty()) {
            if (eventFrames.incrementAndGet() <= MAX_EVENT_FRAMES) {
                events.add(new Happened(event.frame(), happened));
            } else {
                eventFrames.decrementAndGet();
                lostEventFrames.incrementAndGet();
            }
        }
        published = event.frame();
        bring();
    }

    // ---- any thread ----

    /** Has something told to a client on the event loop, before the next perception. */
    void later(Runnable report) {
        reports.add(report);
        bring();
    }

    private void bring() {
        news = true;
        wake.run();
    }

    /** True if there is something to tell, or somebody waits to perceive; event loop's thread. */
    boolean hasWork() {
        return news || owesPerceptions;
    }

    /** The session is told nothing any more. */
    void dismiss(Session session) {
        leavers.add(session);
    }

    /** As {@link #later}, in ACT: with the frame that is being made. */
    void withFrame(Runnable report) {
        reports.add(report);
    }

    /** The last frame that was published. */
    long published() {
        return published;
    }

    // ---- the event loop's thread ----

    /** Writes what agents perceive. */
    Telling telling() {
        return telling;
    }

    /** Who perceives how much. */
    PerceptionShares<Session> shares() {
        return shares;
    }

    /** From now on the session is told what happens. */
    void admit(Session session) {
        members.put(session.name(), session);
    }

    /** The world has gone back: bodies may be others, and everybody who perceives begins anew. */
    void tellRewound(Rewound rewound) {
        for (Session member : members.values()) {
            Optional.ofNullable(rewound.bodies().get(member.name())).ifPresent(member::embodied);
            member.perceptions().restart(rewound.frame());
        }
    }

    /** Tells what there is. */
    void tell() {
        news = false;
        try {
            publish();
        } catch (Throwable e) { // nobody else would tell agents anything, or know why
            log.error("telling agents about frame " + published + " failed", e);
        }
    }

    private void publish() {
        dropWhoHasLeft();
        // First the snapshot, then events, then commands: so that whoever perceives a frame has
        // been told before what happened in it, and whoever joined in a frame is there to hear its
        // events. Events wait for the snapshot of their frame, which says who perceives what they
        // are about.
        Optional<WorldSnapshot> snapshot = unservedSnapshot();
        try {
            for (Runnable report = reports.poll(); report != null; report = reports.poll()) {
                report.run();
            }
            boolean wanted =
                    snapshot.filter(frame -> isWanted(frame, !events.isEmpty())).isPresent();
            boolean isRead =
                    owesPerceptions
                            && snapshot.filter(frame -> frame.frame() == served).isPresent();
            owesPerceptions = false;
            if (wanted && !isRead && !observatory.read(snapshot.get())) {
                return; // overwritten while we read: the next frame is here already
            }
            served = snapshot.map(WorldSnapshot::frame).orElse(served);
            tellEvents();
            if (wanted) {
                serve(snapshot.get());
            }
        } finally {
            snapshot.ifPresent(WorldSnapshot::close);
        }
        afterFrame.run();
    }

    private void dropWhoHasLeft() {
        for (Session gone = leavers.poll(); gone != null; gone = leavers.poll()) {
            members.remove(gone.name(), gone); // not who has come under that name since
            audience.forget(gone);
        }
    }

    private Optional<WorldSnapshot> unservedSnapshot() {
        if (published == served && !owesPerceptions) {
            return Optional.empty();
        }
        Optional<WorldSnapshot> latest = port.snapshots().acquireLatest();
        if (latest.isPresent() && latest.get().frame() > published) {
            latest.get().close(); // its events are not here yet; we are woken when they are
            return Optional.empty();
        }
        return latest;
    }

    /**
     * All events of the frames up to the one that is served: they were here before its snapshot.
     */
    private void tellEvents() {
        int lost = lostEventFrames.getAndSet(0);
        if (lost > 0) {
            log.warn(
                    "agents will never hear the events of "
                            + lost
                            + " frames: too many were waiting");
        }
        if (events.isEmpty()) {
            return;
        }
        audience.locate(members.values(), observatory);
        long end = System.nanoTime() + ACTS_NANOS;
        var acts = new Gap();
        var absences = new Gap();
        var own = new HashMap<Session, Integer>();
        for (Happened next = events.peek();
                next != null && next.frame <= served;
                next = events.peek()) {
            events.remove();
            eventFrames.decrementAndGet();
            int absent = 0;
            for (WorldEvent event : next.events) {
                if (event.type().equals(ACTED) && (acts.count > 0 || System.nanoTime() - end > 0)) {
                    tell(event, false);
                    acts.add(next.frame);
                } else if (isAbsence(event)
                        && (absent++ >= MAX_ABSENCES || System.nanoTime() - end > 0)) {
                    tellAgent(event).ifPresent(agent -> own.merge(agent, 1, Integer::sum));
                    absences.add(next.frame);
                } else {
                    tell(event, true);
                }
            }
        }
        if (acts.count + absences.count > 0) {
            for (Session member : members.values()) {
                Gap gap = member.isInLockStep() ? absences : acts.with(absences);
                long count = gap.count - own.getOrDefault(member, 0);
                if (count > 0) {
                    member.miss(count, gap.first, gap.last);
                }
            }
        }
    }

    /** Events that clients miss, and the frames that they are of. */
    private static final class Gap {
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

    /** Whether anybody perceives a frame, or has to be able to perceive what events are about. */
    private boolean isWanted(WorldSnapshot snapshot, boolean news) {
        long frame = snapshot.frame();
        for (Session member : members.values()) {
            if (member.perceptions().isDue(frame) || news && member.hasSensors()) {
                return true;
            }
        }
        return false;
    }

    /**
     * @param all also to clients in real time
     */
    private void tell(WorldEvent event, boolean all) {
        if (!all && !audience.hasLockStep()) {
            return;
        }
        Mentions mentions = Mentions.in(event, observatory, this::bodyOf);
        var heard = new HeardEvent(event);
        tell(audience.withoutSensors(), all, mentions, heard);
        tell(audience.of(mentions, observatory), all, mentions, heard);
    }

    /** World files may raise events of these types, too, with other fields. */
    private static boolean isAbsence(WorldEvent event) {
        return ABSENCES.contains(event.type())
                && event.fields().containsKey(Mentions.AGENT)
                && event.fields().containsKey("body");
    }

    /** Sends an event to the agent that it is about. @return the agent, if it was sent */
    private Optional<Session> tellAgent(WorldEvent event) {
        Session agent = members.get(String.valueOf(event.fields().get(Mentions.AGENT)));
        if (agent == null) {
            return Optional.empty();
        }
        Mentions mentions = Mentions.in(event, observatory, this::bodyOf);
        return tell(agent, mentions, new HeardEvent(event)) ? Optional.of(agent) : Optional.empty();
    }

    private void tell(
            Collection<Session> hearers, boolean all, Mentions mentions, HeardEvent heard) {
        for (Session member : hearers) {
            if (!all && !member.isInLockStep()) {
                continue;
            }
            tell(member, mentions, heard);
        }
    }

    /**
     * @return false if it does not sense what the event is about
     */
    private boolean tell(Session member, Mentions mentions, HeardEvent heard) {
        Optional<BitSet> fields = member.hear(heard.event(), mentions, observatory);
        fields.ifPresent(told -> member.tell(heard.with(told, member.encoding())));
        return fields.isPresent();
    }

    private Optional<String> bodyOf(String agent) {
        return Optional.ofNullable(members.get(agent)).flatMap(Session::body);
    }

    private View look(Session member) {
        View view = member.look(observatory);
        if (member.hasSensors()) {
            audience.shows(member, view);
        }
        return view;
    }

    private void serve(WorldSnapshot snapshot) {
        View everything = observatory.everything();
        telling.begin(everything);
        shares.begin(members.values(), everything.frame(), System.nanoTime());
        for (Session member : members.values()) {
            if (member.perceptions().isDue(everything.frame())
                    && shares.isServedNow(member)
                    && !serve(member, snapshot)) {
                return; // overwritten while we read: the next frame is here already
            }
        }
        for (Session member : shares.waiting()) {
            if (!shares.isTimeLeft()) {
                owesPerceptions = true;
                return;
            }
            if (!serve(member, snapshot)) {
                return;
            }
        }
    }

    /**
     * @return false if the frame is gone
     */
    private boolean serve(Session member, WorldSnapshot snapshot) {
        long begin = System.nanoTime();
        boolean there =
                member.perceptions()
                        .serve(
                                observatory.everything().frame(),
                                relations ->
                                        relations
                                                ? member.relate(look(member), observatory, snapshot)
                                                : Optional.of(look(member)));
        shares.serve(member.perceptionCost(), System.nanoTime() - begin);
        return there;
    }
}
