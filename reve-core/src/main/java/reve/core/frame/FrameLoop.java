// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import org.jspecify.annotations.Nullable;

import reve.core.world.Activity;
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
 * Makes the frames of a world, all on the thread that calls {@link #step} or {@link #run}, which
 * thereby owns the world.
 *
 * <p>Frame 0 is the world as it was built: before the first frame it is derived and published, so
 * that readers can see it. A frame ends at a x steps x dt of simulated time, where a is the world's
 * age in frames.
 */
public final class FrameLoop {

    /**
     * Most frames that a late loop runs without a pause to catch up; older lateness is given up.
     */
    public static final int MAX_CATCH_UP_FRAMES = 4;

    private static final long UNLIMITED = Long.MAX_VALUE;
    private static final long AT_WORK = Long.MIN_VALUE;

    /** How long a paused loop sleeps at most; whoever resumes it wakes it up. */
    private static final long PAUSE_NANOSECONDS = 100_000_000;

    private static final FramePhase[] PHASES = FramePhase.values();

    private final World world;
    private final FrameBus bus;
    private final FrameEvent event;
    private final Pacing pacing;
    private final Pacer pacer;
    private final AtomicLongArray phaseNanoseconds = new AtomicLongArray(PHASES.length);
    private final AtomicLong busyNanoseconds = new AtomicLong();
    private final AtomicLong frames = new AtomicLong();
    private final FrameClock clock;

    /** The last frame that {@link #run} may make; {@link #UNLIMITED} unless paused. */
    private final AtomicLong lastAllowed = new AtomicLong(UNLIMITED);

    /** The last frame that was begun. */
    private final AtomicLong begunFrame = new AtomicLong();

    private final AtomicReference<@Nullable FramePhase> phase = new AtomicReference<>();

    /** When the wait of the loop's thread ends; {@link #AT_WORK} unless it waits [ns]. */
    private final AtomicLong waitEnd = new AtomicLong(AT_WORK);

    private final Queue<Runnable> errands = new ConcurrentLinkedQueue<>();
    private final BooleanSupplier disturbed = this::isDisturbed;
    private boolean begun;
    private boolean making;
    private volatile FrameGate gate = FrameGate.OPEN;
    private volatile boolean stopped;
    private volatile @Nullable Thread runner;

    public FrameLoop(World world, FrameBus bus, Timing timing, Pacing pacing) {
        this(world, bus, timing, pacing, FrameClock.SYSTEM);
    }

    /**
     * @param clock what paces and profiles the frames; it never reaches the world
     */
    public FrameLoop(World world, FrameBus bus, Timing timing, Pacing pacing, FrameClock clock) {
        this.world = world;
        this.bus = bus;
        this.event = new FrameEvent(world, timing);
        this.clock = clock;
        this.pacing = pacing;
        this.pacer = new Pacer(timing, pacing, clock);
        world.forces().setFramesPerSecond(timing.framesPerSecond());
    }

    /** Makes one frame at once, without pacing and whatever the gate says. */
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
        world.beginFrame();
        dispatch(frame, FramePhase.INTAKE);
        dispatch(frame, FramePhase.ACT);
        world.forces().apply();
        dispatch(frame, FramePhase.PHYSICS);
        world.forces().withdraw();
        world.releaseReplacedMemory();
        dispatch(frame, FramePhase.DERIVE);
        publish(frame);
        add(busyNanoseconds, clock.nanoTime() - start);
        frames.setRelease(frame);
    }

    /**
     * The world has become another one, as that frame shows it: the next to be made is the one
     * after it, and before it this one is derived and published. World's thread, between frames.
     *
     * @param frame the last one made, or a later one
     * @throws IllegalStateException if a frame is being made
     */
    public void continueAfter(long frame) {
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
        frames.setRelease(frame);
        begunFrame.set(frame);
        lastAllowed.updateAndGet(last -> Math.max(last, frame));
        begun = false;
        gate.continuesAfter(frame);
    }

    /** From now on {@link #run} asks this gate before each frame. Any thread. */
    public void setGate(FrameGate gate) {
        this.gate = gate;
        wake();
    }

    /** Has {@link #run}, if it waits, look again at once whether it may go on. Any thread. */
    public void wake() {
        LockSupport.unpark(runner);
        gate.wake();
    }

    /**
     * Has something done between two frames, as soon as none is being made: at once while the loop
     * is paused or waits. If the world is another one then, it is derived and published at once,
     * too. Any thread.
     *
     * @param errand called on the world's thread; must not throw
     */
    public void betweenFrames(Runnable errand) {
        errands.add(errand);
        wake();
    }

    /**
     * Executes the prompt commands of a queue now, unless the loop is paused: what they change
     * belongs to the next frame, as if that had executed them first. World's thread, between
     * frames.
     */
    public void executePrompt(CommandQueue commands) {
        if (!isPaused()) {
            event.set(frame() + 1, FramePhase.ACT);
            commands.executePrompt(event);
        }
    }

    /**
     * Makes that many paced frames, fewer if {@link #stop()} is called or the thread interrupted.
     *
     * @param count 0 only publishes frame 0, if that has not happened yet
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

    /** Makes paced frames until {@link #stop()} is called or the thread interrupted. */
    public void run() {
        run(Long.MAX_VALUE);
    }

    /** Ends {@link #run} after the current frame, now and ever after. Any thread. */
    public void stop() {
        stopped = true;
        wake();
    }

    /** True once {@link #stop()} was called. Any thread. */
    public boolean isStopped() {
        return stopped;
    }

    /**
     * Keeps {@link #run} from making another frame, until it is resumed. Any thread.
     *
     * @return the frame after which it pauses: the last one that was begun
     */
    public synchronized long pause() {
        lastAllowed.set(0); // from here on none is begun, or the loop looks again
        long last = begunFrame.get();
        lastAllowed.set(last);
        wake(); // who waits for the gate waits no longer
        return last;
    }

    /** Lets {@link #run} go on after a pause, as if no time had passed. Any thread. */
    public synchronized void resume() {
        lastAllowed.set(UNLIMITED);
        wake();
    }

    /**
     * Lets {@link #run} make that many frames more and pause then. Any thread.
     *
     * @return the frame after which it pauses
     */
    public synchronized long resume(long count) {
        long paused = lastAllowed.get();
        long last = (paused == UNLIMITED ? pause() : paused) + count;
        lastAllowed.set(last);
        wake();
        return last;
    }

    /** True while no other frame may be made. Any thread. */
    public boolean isPaused() {
        return lastAllowed.get() <= frame();
    }

    /** How fast {@link #run} goes. */
    public Pacing pacing() {
        return pacing;
    }

    /** The world whose frames these are; its owner is the thread that makes them. */
    public World world() {
        return world;
    }

    /** What the world's thread does now. Any thread. */
    public Activity activity() {
        return world.activity();
    }

    /** Returns the thread that {@link #run} is called by, or null. Any thread. */
    public @Nullable Thread thread() {
        return runner;
    }

    /** Returns the phase whose listeners are called now, or null. Any thread. */
    public @Nullable FramePhase phase() {
        return phase.getAcquire();
    }

    /**
     * True while the loop's thread waits for a pause to end, or for the gate or the next frame's
     * time, and for these no longer than it intended to. Any thread.
     */
    public boolean isWaiting() {
        long end = waitEnd.getAcquire();
        return end != AT_WORK && (isPaused() || clock.nanoTime() - end <= 0);
    }

    /** Frames completed. Any thread. */
    public long frame() {
        return frames.getAcquire();
    }

    /** Where the time went so far. Any thread. */
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
                byPhase);
    }

    private void begin() {
        if (!begun) {
            begun = true;
            dispatch(frame(), FramePhase.DERIVE);
            publish(frame());
        }
    }

    /** Those that are there now: who sends more does not keep frames from being made. */
    private void runErrands() {
        if (errands.isEmpty()) {
            return;
        }
        for (int waiting = errands.size(); waiting > 0; waiting--) {
            errands.remove().run();
            begin();
        }
    }

    private void publish(long frame) {
        world.fixEvents();
        dispatch(frame, FramePhase.PUBLISH);
        world.endFrame();
    }

    private void dispatch(long frame, FramePhase phase) {
        long start = clock.nanoTime();
        event.set(frame, phase);
        if (phase.structureMayChange()) {
            world.guard().unlockStructure();
        } else {
            world.guard().lockStructure(phase.name());
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

    /** Waits while paused or held by the gate. @return false if no more frames are wanted */
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
        if (isPaused()) {
            clock.park(nanoseconds);
        } else {
            gate.await(nanoseconds, disturbed, clock);
        }
        waitEnd.setRelease(AT_WORK);
    }

    private boolean isDisturbed() {
        return !errands.isEmpty() || isPaused() || stopped;
    }

    /** How long a frame may not begin yet, at most until looked at again [ns]. */
    private long nanosecondsHeld(long frame) {
        if (lastAllowed.get() < frame) {
            gate.paused();
            return PAUSE_NANOSECONDS;
        }
        return gate.nanosecondsToWait(frame, clock.nanoTime());
    }

    /** Begins a frame unless paused; whoever pauses meanwhile learns of it, or stops it. */
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
            clock.park(wait);
            waitEnd.setRelease(AT_WORK);
            runErrands();
            wait = pacer.nanosecondsToWait();
        }
    }

    private static void add(AtomicLong sum, long value) {
        sum.setRelease(sum.getPlain() + value);
    }
}
