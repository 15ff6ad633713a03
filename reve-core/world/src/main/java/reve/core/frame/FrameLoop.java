// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import org.jspecify.annotations.Nullable;

import reve.core.world.Activity;
import reve.core.world.FrameControl;
import reve.core.world.World;

import java.util.EnumMap;
import java.util.Map;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.AtomicLongArray;
import java.util.concurrent.atomic.AtomicReference;
import java.util.concurrent.locks.LockSupport;
import java.util.function.BooleanSupplier;

/**
 * The loop that makes the frames of a world. It runs on the thread that calls {@link #step} or
 * {@link #run}, and this thread owns the world.
 *
 * <p>Frame 0 is the initial world. Only the phases DERIVE and PUBLISH run for it, so that readers
 * can see the world before the first frame. A frame ends at the simulated time {@code age * steps *
 * dt}, where {@code age} is the world's age in frames.
 */
public final class FrameLoop {

    /**
     * Maximum number of frames that a late loop makes without waiting, to catch up with its
     * schedule. The loop does not make up for a longer delay.
     */
    public static final int MAX_CATCH_UP_FRAMES = 4;

    private static final long UNLIMITED = Long.MAX_VALUE;
    private static final long AT_WORK = Long.MIN_VALUE;

    /**
     * Maximum time for which a paused loop sleeps without a check [ns]. The end of the pause wakes
     * the loop earlier.
     */
    private static final long PAUSE_NANOSECONDS = 100_000_000;

    /**
     * Time limit for errands between two frames [ns]. It is checked after each errand, so the last
     * errand may exceed it.
     */
    private static final long ERRANDS_NANOSECONDS = 10_000_000;

    private static final FramePhase[] PHASES = FramePhase.values();

    private final World world;
    private final FrameControl control;
    private final FrameBus bus;
    private final FrameEvent event;
    private final Pacing pacing;
    private final Pacer pacer;
    private final AtomicLongArray phaseNanoseconds = new AtomicLongArray(PHASES.length);
    private final AtomicLong busyNanoseconds = new AtomicLong();
    private final FrameTimes frameTimes = new FrameTimes();
    private final AtomicLong frames = new AtomicLong();
    private final FrameClock clock;

    /** Number of the last frame that {@link #run} may make; {@link #UNLIMITED} unless paused. */
    private final AtomicLong lastAllowed = new AtomicLong(UNLIMITED);

    /** Number of the last frame that has begun. */
    private final AtomicLong begunFrame = new AtomicLong();

    private final AtomicReference<@Nullable FramePhase> phase = new AtomicReference<>();

    /**
     * Time at which the loop's thread will end its wait [ns]; {@link #AT_WORK} while the thread
     * does not wait.
     */
    private final AtomicLong waitEnd = new AtomicLong(AT_WORK);

    private final Queue<Runnable> errands = new ConcurrentLinkedQueue<>();
    private final BooleanSupplier disturbed = this::isDisturbed;
    private boolean begun;
    private boolean making;
    private volatile FrameGate gate = FrameGate.OPEN;
    private volatile boolean stopped;
    private volatile boolean suspended;
    private volatile @Nullable Thread runner;

    /** Creates a loop that uses the system's clock. */
    public FrameLoop(World world, FrameBus bus, Timing timing, Pacing pacing) {
        this(world, bus, timing, pacing, FrameClock.SYSTEM);
    }

    /**
     * @param clock determines when frames run and measures them; the world has no access to it
     */
    public FrameLoop(World world, FrameBus bus, Timing timing, Pacing pacing, FrameClock clock) {
        this.world = world;
        this.control = FrameControl.of(world);
        this.bus = bus;
        this.event = new FrameEvent(world, timing);
        this.clock = clock;
        this.pacing = pacing;
        this.pacer = new Pacer(timing, pacing, clock);
        control.setFramesPerSecond(timing.framesPerSecond());
    }

    /** Makes one frame at once, without pacing and without asking the gate. */
    public void step() {
        world.guard().claim();
        runErrands();
        begin();
        make();
    }

    private void make() {
        long start = clock.nanoTime();
        long frame = frames.getPlain() + 1;
        begunFrame.set(frame);
        control.begin();
        dispatch(frame, FramePhase.INTAKE);
        dispatch(frame, FramePhase.ACT);
        control.applyForces();
        dispatch(frame, FramePhase.PHYSICS);
        control.endPhysics();
        dispatch(frame, FramePhase.DERIVE);
        publish(frame);
        long duration = clock.nanoTime() - start;
        add(busyNanoseconds, duration);
        frameTimes.add(duration);
        frames.setRelease(frame);
    }

    /**
     * Continues with the frame after {@code frame}, because the caller has replaced the state of
     * the world. The loop runs the phases DERIVE and PUBLISH for the new state before that frame.
     * For the world's thread, between frames.
     *
     * @param frame number of the last completed frame, or a higher number
     * @throws IllegalStateException if a frame is in progress
     */
    public void continueAfter(long frame) {
        requireContinuable(frame);
        frames.setRelease(frame);
        begunFrame.set(frame);
        lastAllowed.updateAndGet(last -> Math.max(last, frame));
        begun = false;
        gate.continuesAfter(frame);
    }

    /**
     * Checks that {@link #continueAfter} is possible, and changes nothing.
     *
     * @throws IllegalStateException if a frame is in progress
     * @throws IllegalArgumentException if {@code frame} is less than the number of completed frames
     */
    public void requireContinuable(long frame) {
        if (making) {
            throw new IllegalStateException(
                    "frame "
                            + (frame() + 1)
                            + " is being made; continue "
                            + "after frame "
                            + frame
                            + " when it is done");
        }
        if (frame < frame()) {
            throw new IllegalArgumentException(
                    "frame is "
                            + frame
                            + ", expected "
                            + frame()
                            + " or more: frames never go back");
        }
    }

    /** Sets the gate that {@link #run} asks before each frame. For any thread. */
    public void setGate(FrameGate gate) {
        this.gate = gate;
        wake();
    }

    /** Makes a waiting {@link #run} check at once whether it may continue. For any thread. */
    public void wake() {
        LockSupport.unpark(runner);
        gate.wake();
    }

    /**
     * Runs an errand (a task between two frames) as soon as no frame is in progress. A loop that is
     * paused or waits runs the errand at once. The phases DERIVE and PUBLISH follow at once if the
     * errand replaces the world's state. For any thread.
     *
     * @param errand called on the world's thread; must not throw
     */
    public void betweenFrames(Runnable errand) {
        errands.add(errand);
        wake();
    }

    /**
     * Executes the prompt commands of a queue ({@link Command#isPrompt}) now, unless the loop is
     * paused. Their changes belong to the next frame, as if that frame had executed them first. For
     * the world's thread, between frames.
     *
     * @return true if prompt commands remain, for example because {@link Command#isCostly costly}
     *     ones exceeded their time limit
     */
    public boolean executePrompt(CommandQueue commands) {
        if (isPaused()) {
            return false;
        }
        event.set(frame() + 1, FramePhase.ACT);
        return commands.executePrompt(event);
    }

    /**
     * Makes {@code count} frames, each when it is due. Makes fewer frames if {@link #stop()} is
     * called or the thread is interrupted.
     *
     * @param count number of frames; 0 only publishes frame 0, unless it was published before
     */
    public void run(long count) {
        world.guard().claim();
        runner = Thread.currentThread();
        try {
            begin();
            pacer.start();
            for (long i = 0; i < count && mayBegin(); i++) {
                make();
                pacer.frameDone();
                awaitNextFrame();
            }
        } finally {
            runner = null;
        }
    }

    /**
     * Makes frames, each when it is due, until {@link #stop()} is called or the thread is
     * interrupted.
     */
    public void run() {
        run(Long.MAX_VALUE);
    }

    /** Ends {@link #run} after the current frame, permanently. For any thread. */
    public void stop() {
        stopped = true;
        wake();
    }

    /** Returns true after {@link #stop()} was called. For any thread. */
    public boolean isStopped() {
        return stopped;
    }

    /**
     * Prevents {@link #run} from beginning another frame until {@link #resume()} is called. For any
     * thread.
     *
     * @return number of the last frame before the pause, which may still be in progress
     */
    public synchronized long pause() {
        // After this assignment, the loop begins no frame. A loop that is just beginning a frame
        // notices the pause at its second check.
        lastAllowed.set(0);
        long last = begunFrame.get();
        lastAllowed.set(last);
        wake(); // a loop that waits for the gate checks it again
        return last;
    }

    /**
     * Resumes {@link #run} after a pause. The duration of the pause does not count as delay. For
     * any thread.
     */
    public synchronized void resume() {
        lastAllowed.set(UNLIMITED);
        wake();
    }

    /**
     * Resumes {@link #run} for {@code count} more frames, after which the loop pauses again. For
     * any thread.
     *
     * @return number of the frame after which the loop pauses again
     */
    public synchronized long resume(long count) {
        long paused = lastAllowed.get();
        long last = (paused == UNLIMITED ? pause() : paused) + count;
        lastAllowed.set(last);
        wake();
        return last;
    }

    /** Returns true while the loop must not begin another frame. For any thread. */
    public boolean isPaused() {
        return lastAllowed.get() <= frame();
    }

    /**
     * Prevents {@link #run} from beginning another frame, or permits it again. This is independent
     * of {@link #pause}: resuming the loop does not end it. The loop runs errands meanwhile. The
     * duration does not count as delay. For any thread.
     */
    public void suspend(boolean isSuspended) {
        if (suspended != isSuspended) {
            suspended = isSuspended;
            wake(); // a loop that waits for the gate checks it again
        }
    }

    /** Returns whether {@link #suspend} prevents the next frame. For any thread. */
    public boolean isSuspended() {
        return suspended;
    }

    /**
     * Sets the speed of {@link #run}: simulated time divided by time of the clock, initially 1. The
     * speed affects neither the content of frames nor a loop with {@link Pacing#FAST}. For any
     * thread.
     *
     * @param factor above 0
     */
    public void setSpeed(double factor) {
        pacer.setSpeed(factor);
        wake();
    }

    /** Returns the speed, see {@link #setSpeed}. For any thread. */
    public double speed() {
        return pacer.speed();
    }

    /** Returns whether {@link #run} follows the clock or runs as fast as possible. */
    public Pacing pacing() {
        return pacing;
    }

    /** Returns the world. Only the thread that makes the frames may use it. */
    public World world() {
        return world;
    }

    /**
     * Returns the activity, which describes the rule, condition or action that the world's thread
     * evaluates now. For any thread.
     */
    public Activity activity() {
        return world.activity();
    }

    /** Returns the thread that is in {@link #run}, or null if there is none. For any thread. */
    public @Nullable Thread thread() {
        return runner;
    }

    /** Returns the phase whose listeners are being called; null at other times. For any thread. */
    public @Nullable FramePhase phase() {
        return phase.getAcquire();
    }

    /**
     * Returns true while the loop's thread waits for the end of a pause, for the gate or for the
     * time of the next frame. Returns false if a wait takes longer than planned. For any thread.
     */
    public boolean isWaiting() {
        long end = waitEnd.getAcquire();
        return end != AT_WORK && (isPaused() || clock.nanoTime() - end <= 0);
    }

    /** Returns the number of completed frames. For any thread. */
    public long frame() {
        return frames.getAcquire();
    }

    /**
     * Returns the sum of the durations of all frames [ns], as in {@link #profile}. For any thread.
     */
    public long busyNanoseconds() {
        return busyNanoseconds.getAcquire();
    }

    /**
     * Returns the time in the listeners of a phase so far [ns], as in {@link #profile}. For any
     * thread.
     */
    public long phaseNanoseconds(FramePhase phase) {
        return phaseNanoseconds.getAcquire(phase.ordinal());
    }

    /** Returns the number of frames and their times so far. For any thread. */
    public FrameProfile profile() {
        Map<FramePhase, Long> byPhase = new EnumMap<>(FramePhase.class);
        for (FramePhase phase : PHASES) {
            byPhase.put(phase, phaseNanoseconds.getAcquire(phase.ordinal()));
        }
        return new FrameProfile(
                frame(),
                pacer.overruns(),
                pacer.droppedFrames(),
                busyNanoseconds.getAcquire(),
                byPhase,
                frameTimes.counts());
    }

    private void begin() {
        if (!begun) {
            begun = true;
            dispatch(frame(), FramePhase.DERIVE);
            publish(frame());
        }
    }

    /**
     * Runs queued errands until they exceed their time limit, at least one. Errands that are queued
     * during this call wait for the next call, so that a fast sender cannot prevent frames.
     */
    private void runErrands() {
        if (errands.isEmpty()) {
            return;
        }
        long start = clock.nanoTime();
        for (int waiting = errands.size(); waiting > 0; waiting--) {
            errands.remove().run();
            begin();
            if (clock.nanoTime() - start >= ERRANDS_NANOSECONDS) {
                return;
            }
        }
    }

    /** Waits for this duration [ns], unless an errand is queued. */
    private void park(long nanoseconds) {
        if (errands.isEmpty()) {
            clock.park(nanoseconds);
        }
    }

    private void publish(long frame) {
        control.publish();
        dispatch(frame, FramePhase.PUBLISH);
        control.end();
    }

    private void dispatch(long frame, FramePhase phase) {
        long start = clock.nanoTime();
        event.set(frame, phase);
        if (phase.structureMayChange()) {
            control.unlock();
        } else {
            control.lock(phase.name());
        }
        making = true;
        this.phase.setRelease(phase);
        bus.dispatch(event);
        this.phase.setRelease(null);
        making = false;
        int index = phase.ordinal();
        phaseNanoseconds.setRelease(
                index, phaseNanoseconds.getPlain(index) + clock.nanoTime() - start);
    }

    /**
     * Waits while the loop is paused or the gate is closed.
     *
     * @return false if the loop was stopped or its thread was interrupted
     */
    private boolean mayBegin() {
        boolean waited = false;
        runErrands();
        while (isWanted()) {
            long wait = nanosecondsHeld(frame() + 1);
            if (wait > 0) {
                waited = true;
                await(wait);
                runErrands();
            } else if (begin(frame() + 1)) {
                if (waited) {
                    pacer.start();
                }
                return true;
            }
        }
        return false;
    }

    private void await(long nanoseconds) {
        waitEnd.setRelease(clock.nanoTime() + nanoseconds);
        if (isPaused() || suspended) {
            park(nanoseconds);
        } else {
            gate.await(nanoseconds, disturbed, clock);
        }
        waitEnd.setRelease(AT_WORK);
    }

    private boolean isDisturbed() {
        return !errands.isEmpty() || isPaused() || suspended || stopped;
    }

    /**
     * Returns the time after which the loop checks again whether a frame may begin [ns]; 0 or less
     * if the frame may begin.
     */
    private long nanosecondsHeld(long frame) {
        if (suspended || lastAllowed.get() < frame) {
            gate.paused();
            return PAUSE_NANOSECONDS;
        }
        return gate.nanosecondsToWait(frame, clock.nanoTime());
    }

    /**
     * Begins a frame and returns true, unless the loop is paused. Another thread may pause the loop
     * meanwhile. This frame then either runs before the pause or does not begin.
     */
    private boolean begin(long frame) {
        if (lastAllowed.get() < frame) {
            return false;
        }
        begunFrame.set(frame);
        if (lastAllowed.get() < frame) {
            begunFrame.set(frame - 1);
            return false;
        }
        return true;
    }

    private boolean isWanted() {
        return !stopped && !Thread.currentThread().isInterrupted();
    }

    private void awaitNextFrame() {
        long wait = pacer.nanosecondsToWait();
        while (wait > 0 && isWanted()) {
            waitEnd.setRelease(clock.nanoTime() + wait);
            park(wait);
            waitEnd.setRelease(AT_WORK);
            runErrands();
            wait = pacer.nanosecondsToWait();
        }
    }

    private static void add(AtomicLong sum, long value) {
        sum.setRelease(sum.getPlain() + value);
    }
}
