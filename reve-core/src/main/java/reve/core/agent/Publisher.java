package reve.core.agent;

import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import reve.core.frame.FrameEvent;
import reve.core.world.WorldEvent;
import reve.core.world.WorldSnapshot;

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

    /** True if there may be something to tell. */
    boolean hasNews() {
        return news;
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
            boolean wanted = snapshot.filter(frame -> isWanted(frame, !events.isEmpty()))
                    .isPresent();
            boolean isRead = owesPerceptions
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
            log.warn("agents will never hear the events of " + lost
                    + " frames: too many were waiting");
        }
        if (events.isEmpty()) {
            return;
        }
        audience.locate(members.values(), observatory);
        long end = System.nanoTime() + ACTS_NANOS;
        long missed = 0;
        long firstMissed = 0;
        long lastMissed = 0;
        for (Happened next = events.peek(); next != null && next.frame <= served;
                next = events.peek()) {
            events.remove();
            eventFrames.decrementAndGet();
            for (WorldEvent event : next.events) {
                if (event.type().equals(ACTED)
                        && (missed > 0 || System.nanoTime() - end > 0)) {
                    tell(event, false);
                    firstMissed = missed == 0 ? next.frame : firstMissed;
                    lastMissed = next.frame;
                    missed++;
                } else {
                    tell(event, true);
                }
            }
        }
        if (missed > 0) {
            for (Session member : members.values()) {
                if (!member.isInLockStep()) {
                    member.miss(missed, firstMissed, lastMissed);
                }
            }
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

    /** @param all also to clients in real time */
    private void tell(WorldEvent event, boolean all) {
        if (!all && !audience.hasLockStep()) {
            return;
        }
        Mentions mentions = Mentions.in(event, observatory, this::bodyOf);
        var heard = new HeardEvent(event);
        tell(audience.withoutSensors(), all, mentions, heard);
        tell(audience.of(mentions, observatory), all, mentions, heard);
    }

    private void tell(Collection<Session> hearers, boolean all, Mentions mentions,
            HeardEvent heard) {
        for (Session member : hearers) {
            if (!all && !member.isInLockStep()) {
                continue;
            }
            member.hear(heard.event(), mentions, observatory).ifPresent(told ->
                    member.tell(heard.with(told, member.encoding())));
        }
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
            if (member.perceptions().isDue(everything.frame()) && shares.isServedNow(member)
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

    /** @return false if the frame is gone */
    private boolean serve(Session member, WorldSnapshot snapshot) {
        long begin = System.nanoTime();
        boolean there = member.perceptions().serve(observatory.everything().frame(),
                relations -> relations ? member.relate(look(member), observatory, snapshot)
                        : Optional.of(look(member)));
        shares.serve(member.perceptionCost(), System.nanoTime() - begin);
        return there;
    }
}
