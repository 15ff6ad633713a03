// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import org.jspecify.annotations.Nullable;

import reve.core.agent.embodiment.Rewound;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.perception.PerceptionShares;
import reve.core.agent.perception.RelatedViews;
import reve.core.agent.perception.View;
import reve.core.agent.port.WorldPort;
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
import java.util.concurrent.atomic.AtomicReference;

/**
 * Tells agents what the frames brought: results, events, perceptions. The world's thread only
 * leaves word here, without a lock; the event loop does the work for all agents.
 */
public final class Publisher {

    /** Frames with events that may wait to be told; at 60 frames a second a quarter of a minute. */
    private static final int MAX_EVENT_FRAMES = 1024;

    /** In so much time clients in real time are told of acts; those beyond they miss. */
    private static final long ACTS_NANOS = 5_000_000;

    private static final String ACTED = "acted";

    /** What agents in lock-step cause by doing nothing. */
    private static final Set<String> ABSENCES = Set.of("late", "away", "back");

    /** Most events of {@link #ABSENCES} in one frame that a client is sent about other agents. */
    public static final int MAX_ABSENCES = 8;

    private final WorldPort port;
    private final RateLimitedLog log;
    private final Runnable afterFrame;
    private final Observatory observatory = new Observatory();
    private final PerceptionEncoder encoder = new PerceptionEncoder();
    private final RelatedViews<Perceiver> relatedViews = new RelatedViews<>(System::nanoTime);
    private final PerceptionShares<Perceiver> shares = new PerceptionShares<>(System.nanoTime());
    private final Queue<Runnable> reports = new ConcurrentLinkedQueue<>();
    private final Queue<Perceiver> leavers = new ConcurrentLinkedQueue<>();
    private final Queue<Happened> events = new ConcurrentLinkedQueue<>();
    private final AtomicInteger eventFrames = new AtomicInteger();
    private final AtomicInteger lostEventFrames = new AtomicInteger();
    private final Map<String, Perceiver> members = new LinkedHashMap<>();
    private final EventRouting routing = new EventRouting();
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
    public Publisher(WorldPort port, RateLimitedLog log, Runnable afterFrame, Runnable wake) {
        this.port = port;
        this.log = log;
        this.afterFrame = afterFrame;
        this.wake = wake;
    }

    // ---- world's thread ----

    /** Listens to PUBLISH. */
    public void onFrame(FrameEvent event) {
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
    public void later(Runnable report) {
        reports.add(report);
        bring();
    }

    private void bring() {
        news = true;
        wake.run();
    }

    /** True if there is something to tell, or somebody waits to perceive; event loop's thread. */
    public boolean hasWork() {
        return news || owesPerceptions;
    }

    /** The session is told nothing any more. */
    public void dismiss(Perceiver session) {
        leavers.add(session);
    }

    /** As {@link #later}, in ACT: with the frame that is being made. */
    public void withFrame(Runnable report) {
        reports.add(report);
    }

    /** The last frame that was published. */
    public long published() {
        return published;
    }

    // ---- the event loop's thread ----

    /** Writes what agents perceive. */
    public PerceptionEncoder encoder() {
        return encoder;
    }

    /** Who perceives how much. */
    public PerceptionShares<Perceiver> shares() {
        return shares;
    }

    /** From now on the session is told what happens. */
    public void admit(Perceiver session) {
        members.put(session.name(), session);
    }

    /** The world has gone back: bodies may be others, and everybody who perceives begins anew. */
    public void tellRewound(Rewound rewound) {
        for (Perceiver member : members.values()) {
            Optional.ofNullable(rewound.bodies().get(member.name())).ifPresent(member::embodied);
            member.perceptions().restart(rewound.frame());
        }
    }

    /** Tells what there is. */
    public void tell() {
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
                serve();
            }
        } finally {
            snapshot.ifPresent(WorldSnapshot::close);
        }
        afterFrame.run();
    }

    private void dropWhoHasLeft() {
        for (Perceiver gone = leavers.poll(); gone != null; gone = leavers.poll()) {
            members.remove(gone.name(), gone); // not who has come under that name since
            routing.forget(gone);
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
        routing.locate(members.values(), observatory);
        long end = System.nanoTime() + ACTS_NANOS;
        var acts = new Gap();
        var absences = new Gap();
        var own = new HashMap<Perceiver, Integer>();
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
            for (Perceiver member : members.values()) {
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
        for (Perceiver member : members.values()) {
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
        if (!all && !routing.hasLockStep()) {
            return;
        }
        EventSubjects subjects = EventSubjects.in(event, observatory, this::bodyOf);
        var heard = new HeardEvent(event);
        tell(routing.withoutSensors(), all, subjects, heard);
        tell(routing.of(subjects, observatory), all, subjects, heard);
    }

    /** World files may raise events of these types, too, with other fields. */
    private static boolean isAbsence(WorldEvent event) {
        return ABSENCES.contains(event.type())
                && event.fields().containsKey(EventSubjects.AGENT)
                && event.fields().containsKey("body");
    }

    /** Sends an event to the agent that it is about. @return the agent, if it was sent */
    private Optional<Perceiver> tellAgent(WorldEvent event) {
        Perceiver agent = members.get(String.valueOf(event.fields().get(EventSubjects.AGENT)));
        if (agent == null) {
            return Optional.empty();
        }
        EventSubjects subjects = EventSubjects.in(event, observatory, this::bodyOf);
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
     * @return false if it does not sense what the event is about
     */
    private boolean tell(Perceiver member, EventSubjects subjects, HeardEvent heard) {
        Optional<BitSet> fields = member.hear(heard.event(), subjects, observatory);
        fields.ifPresent(told -> member.tell(heard.with(told, member.encoding())));
        return fields.isPresent();
    }

    private Optional<String> bodyOf(String agent) {
        return Optional.ofNullable(members.get(agent)).flatMap(Perceiver::body);
    }

    private View look(Perceiver member) {
        View view = member.look(observatory);
        if (member.hasSensors()) {
            routing.shows(member, view);
        }
        return view;
    }

    private void serve() {
        View everything = observatory.everything();
        long now = System.nanoTime();
        encoder.begin(everything);
        relatedViews.begin(member -> members.get(member.name()) == member);
        shares.begin(members.values(), everything.frame(), now);
        for (Perceiver member : members.values()) {
            if (member.perceptions().isDue(everything.frame()) && shares.isServedNow(member)) {
                serve(member);
            }
        }
        for (Perceiver member : shares.waiting()) {
            if (!shares.isTimeLeft()) {
                owesPerceptions = true;
                return;
            }
            serve(member);
        }
    }

    private void serve(Perceiver member) {
        long begin = System.nanoTime();
        var related = new AtomicReference<@Nullable View>();
        boolean served =
                member.perceptions()
                        .serve(
                                observatory.everything().frame(),
                                relations ->
                                        relations
                                                ? relate(member, related)
                                                : Optional.of(look(member)));
        long nanos = System.nanoTime() - begin;
        if (served) {
            shares.serve(member.perceptionCost(), nanos);
        } else {
            shares.spend(member.perceptionCost(), nanos);
            owesPerceptions = true;
        }
    }

    /**
     * @param known the view with relations, once it is there: two requests get the same
     */
    private Optional<View> relate(Perceiver member, AtomicReference<@Nullable View> known) {
        View view = known.get();
        if (view == null) {
            view = relatedViews.of(member, () -> look(member), observatory).orElse(null);
            known.set(view);
        }
        return Optional.ofNullable(view);
    }
}
