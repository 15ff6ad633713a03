// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.frame.FrameLoop;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.locks.LockSupport;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * Detects and reports stalled worlds. A world is stalled if it should make frames and has made none
 * for some time. The watchdog's thread only reads counters, which the worlds' threads publish in
 * any case. A world does not stall while it is paused, waits for agents in lock-step, or waits
 * until its next frame is due.
 */
final class Watchdog implements AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("watchdog");
    private static final int LOOKS_PER_LIMIT = 5;
    private static final long MAX_PERIOD_NANOS = 1_000_000_000;
    private static final int STACK_DEPTH = 12;
    private static final Pattern JDK = Pattern.compile("(java|javax|jdk|sun)\\.");

    private final WatchdogPlan plan;
    private final List<Watched> worlds = new CopyOnWriteArrayList<>();
    private final long periodNanos;
    private final Thread thread = new Thread(this::watch, "watchdog");
    private volatile boolean closed;

    /** A watched world. */
    record Subject(String world, FrameLoop loop, ServerEvents events) {}

    Watchdog(WatchdogPlan plan, List<Subject> worlds) {
        this.plan = plan;
        worlds.forEach(this::add);
        this.periodNanos = Math.min(plan.limit().toNanos() / LOOKS_PER_LIMIT, MAX_PERIOD_NANOS);
        thread.setDaemon(true);
    }

    /** Starts to watch; does nothing if the limit is 0. */
    void start() {
        if (!plan.limit().isZero()) {
            thread.start();
        }
    }

    /** Watches another world. For any thread. */
    void add(Subject subject) {
        worlds.add(new Watched(subject));
    }

    /** Stops watching a world. For any thread. */
    void remove(Subject subject) {
        worlds.removeIf(watched -> watched.subject == subject);
    }

    @Override
    public void close() {
        closed = true;
        LockSupport.unpark(thread);
    }

    private void watch() {
        long last = System.nanoTime();
        while (!closed) {
            LockSupport.parkNanos(periodNanos);
            long now = System.nanoTime();
            // One check counts at most two periods of time. A longer interval means that the whole
            // process was stopped or had no processor, so the worlds could not run either.
            long seen = Math.min(now - last, 2 * periodNanos);
            last = now;
            for (Watched world : worlds) {
                world.look(seen);
            }
        }
    }

    /** The state of one watched world. For the watchdog's thread only. */
    private final class Watched {
        private final Subject subject;
        private long frame = -1;
        private long stillNanos;
        private long reportAtNanos = plan.limit().toNanos();

        Watched(Subject subject) {
            this.subject = subject;
        }

        void look(long seenNanos) {
            FrameLoop loop = subject.loop;
            Thread thread = loop.thread();
            long now = loop.frame();
            if (thread == null || now != frame || loop.isWaiting()) {
                if (reportAtNanos > plan.limit().toNanos()) {
                    recovered(now);
                }
                frame = now;
                stillNanos = 0;
                reportAtNanos = plan.limit().toNanos();
                return;
            }
            stillNanos += seenNanos;
            if (stillNanos >= reportAtNanos) {
                reportAtNanos *= 2;
                stalled(thread);
            }
        }

        private void stalled(Thread thread) {
            Map<String, Object> fields = new LinkedHashMap<>();
            String phase =
                    Optional.ofNullable(subject.loop.phase())
                            .map(Enum::name)
                            .orElse("between phases");
            String activity =
                    Optional.ofNullable(subject.loop.activity().current())
                            .map(Object::toString)
                            .orElse("");
            List<String> stack = stackOf(thread);
            fields.put("world", subject.world);
            fields.put("frame", frame + 1);
            fields.put("seconds", seconds());
            fields.put("phase", phase);
            if (!activity.isEmpty()) {
                fields.put("activity", activity);
            }
            fields.put("stack", stack);
            subject.events.happened("stalled", fields);
            LOG.error(
                    "the world {} stands still: frame {} takes {} s by now, in {}, {}, at {}",
                    subject.world,
                    frame + 1,
                    seconds(),
                    phase,
                    activity.isEmpty() ? "thread " + thread.getState() : activity,
                    stack.isEmpty() ? "no Java method" : stack.getFirst());
            plan.onStall().ifPresent(Runnable::run);
        }

        private void recovered(long now) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("world", subject.world);
            fields.put("frame", now);
            fields.put("seconds", seconds());
            subject.events.happened("recovered", fields);
            LOG.warn(
                    "the world {} makes frames again: it stood still for {} s",
                    subject.world,
                    seconds());
        }

        private double seconds() {
            return Double.parseDouble(String.format(Locale.ROOT, "%.1f", stillNanos * 1e-9));
        }

        /**
         * Returns the methods on the stack of the thread, innermost method first. Methods of the
         * JDK are omitted.
         */
        private static List<String> stackOf(Thread thread) {
            return Stream.of(thread.getStackTrace())
                    .dropWhile(call -> JDK.matcher(call.getClassName()).lookingAt())
                    .limit(STACK_DEPTH)
                    .map(Watched::place)
                    .toList();
        }

        private static String place(StackTraceElement call) {
            return call.getClassName()
                    + "."
                    + call.getMethodName()
                    + "("
                    + call.getFileName()
                    + ":"
                    + call.getLineNumber()
                    + ")";
        }
    }
}
