package reve.core.agent;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.locks.LockSupport;
import reve.core.frame.FrameEvent;
import reve.core.world.WorldEvent;
import reve.core.world.WorldSnapshot;

/**
 * Tells agents what the frames brought: results, events, perceptions. The world's thread only leaves word here,
 * without a lock; a thread of the publisher's own does the work for all agents.
 */
final class Publisher {

    /** Frames with events that may wait to be told; at 60 frames a second a quarter of a minute. */
    private static final int MAX_EVENT_FRAMES = 1024;

    private final WorldPort port;
    private final RateLimitedLog log;
    private final Runnable afterFrame;
    private final PerceptionEncoder encoder = new PerceptionEncoder();
    private final Queue<Runnable> reports = new ConcurrentLinkedQueue<>();
    private final Queue<List<WorldEvent>> events = new ConcurrentLinkedQueue<>();
    private final AtomicInteger eventFrames = new AtomicInteger();
    private final AtomicInteger lostEventFrames = new AtomicInteger();
    private final List<Session> members = new ArrayList<>();
    private final Thread thread;
    private volatile long published;
    private volatile boolean stopped;
    private long served;

    /** @param afterFrame what else is to be done when a frame has passed, on the publisher's thread */
    Publisher(WorldPort port, RateLimitedLog log, Runnable afterFrame) {
        this.port = port;
        this.log = log;
        this.afterFrame = afterFrame;
        this.thread = Thread.ofPlatform().name("agent publisher").daemon().unstarted(this::run);
    }

    void start() {
        thread.start();
    }

    void stop() {
        stopped = true;
        LockSupport.unpark(thread);
    }

    // ---- world's thread ----

    /** Listens to PUBLISH. */
    void onFrame(FrameEvent event) {
        List<WorldEvent> happened = event.world().events();
        if (!happened.isEmpty()) {
            if (eventFrames.incrementAndGet() <= MAX_EVENT_FRAMES) {
                events.add(happened);
            } else {
                eventFrames.decrementAndGet();
                lostEventFrames.incrementAndGet();
            }
        }
        published = event.frame();
        LockSupport.unpark(thread);
    }

    // ---- any thread ----

    /** Has something told to a client on the publisher's thread, before the next perception. */
    void later(Runnable report) {
        reports.add(report);
        LockSupport.unpark(thread);
    }

    /** The last frame that was published. */
    long published() {
        return published;
    }

    // ---- publisher's thread ----

    /** From now on the session is told what happens. */
    void admit(Session session) {
        members.add(session);
    }

    private void run() {
        while (!stopped) {
            try {
                publish();
            } catch (Throwable e) { // nobody else would tell agents anything, or know why
                log.error("telling agents about frame " + published + " failed", e);
            }
            LockSupport.park(this);
        }
    }

    private void publish() {
        members.removeIf(Session::hasLeft);
        // First the snapshot, then events, then commands: so that whoever perceives a frame has been told before
        // what happened in it, and whoever joined in a frame is there to hear its events.
        Optional<WorldSnapshot> snapshot = unservedSnapshot();
        try {
            List<WorldEvent> news = takeEvents();
            for (Runnable report = reports.poll(); report != null; report = reports.poll()) {
                report.run();
            }
            news.forEach(this::tell);
            snapshot.ifPresent(this::serve);
        } finally {
            snapshot.ifPresent(WorldSnapshot::close);
        }
        afterFrame.run();
    }

    private Optional<WorldSnapshot> unservedSnapshot() {
        if (published == served) {
            return Optional.empty();
        }
        Optional<WorldSnapshot> latest = port.snapshots().acquireLatest();
        if (latest.isPresent() && latest.get().frame() > published) {
            latest.get().close(); // its events are not here yet; we are woken when they are
            return Optional.empty();
        }
        return latest;
    }

    private List<WorldEvent> takeEvents() {
        int lost = lostEventFrames.getAndSet(0);
        if (lost > 0) {
            log.warn("agents will never hear the events of " + lost + " frames: too many were waiting");
        }
        var news = new ArrayList<WorldEvent>();
        for (List<WorldEvent> frame = events.poll(); frame != null; frame = events.poll()) {
            eventFrames.decrementAndGet();
            news.addAll(frame);
        }
        return news;
    }

    private void tell(WorldEvent event) {
        byte[] line = new ServerMessage.Event(event.frame(), event.type(), event.fields()).line();
        members.forEach(member -> member.tell(event.frame(), line));
    }

    private void serve(WorldSnapshot snapshot) {
        long frame = snapshot.frame();
        var bodies = new HashMap<Boolean, Optional<byte[]>>();
        PerceptionRequests.Bodies encoded = relations ->
                bodies.computeIfAbsent(relations, asked -> encoder.encode(snapshot, asked));
        for (Session member : members) {
            if (member.perceptions().isDue(frame) && !member.perceptions().serve(frame, encoded)) {
                return; // overwritten while we read: the next frame is here already
            }
        }
        served = frame;
    }
}
