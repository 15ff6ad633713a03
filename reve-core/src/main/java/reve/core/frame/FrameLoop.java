package reve.core.frame;

import java.util.EnumMap;
import java.util.Map;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.AtomicLongArray;
import java.util.concurrent.locks.LockSupport;
import org.jspecify.annotations.Nullable;
import reve.core.world.World;

/**
 * Makes the frames of a world, all on the thread that calls {@link #step} or {@link #run}, which
 * thereby owns the world.
 *
 * <p>Frame 0 is the world as it was built: before the first frame it is derived and published, so
 * that readers can see it. Frame n ends at n x steps x dt of simulated time.
 */
public final class FrameLoop {

    /**
     * Most frames that a late loop runs without a pause to catch up; older lateness is given up.
     */
    public static final int MAX_CATCH_UP_FRAMES = 4;

    private static final FramePhase[] PHASES = FramePhase.values();

    private final World world;
    private final FrameBus bus;
    private final FrameEvent event;
    private final Pacer pacer;
    private final AtomicLongArray phaseNanoseconds = new AtomicLongArray(PHASES.length);
    private final AtomicLong busyNanoseconds = new AtomicLong();
    private final AtomicLong frames = new AtomicLong();
    private final FrameClock clock;
    private boolean begun;
    private boolean making;
    private volatile boolean stopped;
    private volatile @Nullable Thread runner;

    public FrameLoop(World world, FrameBus bus, Timing timing, Pacing pacing) {
        this(world, bus, timing, pacing, FrameClock.SYSTEM);
    }

    /** @param clock what paces and profiles the frames; it never reaches the world */
    public FrameLoop(World world, FrameBus bus, Timing timing, Pacing pacing, FrameClock clock) {
        this.world = world;
        this.bus = bus;
        this.event = new FrameEvent(world, timing);
        this.clock = clock;
        this.pacer = new Pacer(timing, pacing, clock);
    }

    /** Makes one frame at once, without pacing. */
    public void step() {
        world.claim();
        begin();
        long start = clock.nanoTime();
        long frame = frames.getPlain() + 1;
        dispatch(frame, FramePhase.INTAKE);
        dispatch(frame, FramePhase.ACT);
        dispatch(frame, FramePhase.PHYSICS);
        world.releaseReplacedMemory();
        dispatch(frame, FramePhase.DERIVE);
        publish(frame);
        add(busyNanoseconds, clock.nanoTime() - start);
        frames.setRelease(frame);
    }

    /**
     * The world has become that of another frame: the next to be made is the one after it, and
     * before it this one is derived and published. World's thread, between frames.
     *
     * @param frame 0 or more
     * @throws IllegalStateException if a frame is being made
     */
    public void continueAfter(long frame) {
        if (making) {
            throw new IllegalStateException("frame " + (frame() + 1) + " is being made; continue "
                    + "after frame " + frame + " when it is done");
        }
        if (frame < 0) {
            throw new IllegalArgumentException("frame is " + frame + ", expected 0 or more");
        }
        frames.setRelease(frame);
        begun = false;
    }

    /**
     * Makes that many paced frames, fewer if {@link #stop()} is called or the thread interrupted.
     *
     * @param count 0 only publishes frame 0, if that has not happened yet
     */
    public void run(long count) {
        world.claim();
        begin();
        runner = Thread.currentThread();
        try {
            pacer.start();
            for (long i = 0; i < count && isWanted(); i++) {
                step();
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
        LockSupport.unpark(runner);
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
        return new FrameProfile(frame(), pacer.overruns(), pacer.droppedFrames(),
                busyNanoseconds.getAcquire(), byPhase);
    }

    private void begin() {
        if (!begun) {
            begun = true;
            dispatch(frame(), FramePhase.DERIVE);
            publish(frame());
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
            world.unlockStructure();
        } else {
            world.lockStructure(phase.name());
        }
        making = true;
        bus.dispatch(event);
        making = false;
        int index = phase.ordinal();
        phaseNanoseconds.setRelease(index,
                phaseNanoseconds.getPlain(index) + clock.nanoTime() - start);
    }

    private boolean isWanted() {
        return !stopped && !Thread.currentThread().isInterrupted();
    }

    private void awaitNextFrame() {
        long wait = pacer.nanosecondsToWait();
        while (wait > 0 && isWanted()) {
            clock.park(wait);
            wait = pacer.nanosecondsToWait();
        }
    }

    private static void add(AtomicLong sum, long value) {
        sum.setRelease(sum.getPlain() + value);
    }
}
