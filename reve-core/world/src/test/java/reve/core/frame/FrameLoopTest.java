// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.catchThrowable;

import org.junit.jupiter.api.Test;

import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;

class FrameLoopTest {

    private static final long MILLISECOND = 1_000_000;

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final FrameBus bus = new FrameBus();
    private final ManualClock clock = new ManualClock();
    private final List<Long> starts = new ArrayList<>();

    /** A clock on which time passes only during waits and work. */
    private static final class ManualClock implements FrameClock {
        private long now = 123_456_789;
        private long divisor = 1;
        private Runnable onPark = () -> {};

        @Override
        public long nanoTime() {
            return now;
        }

        @Override
        public void park(long nanoseconds) {
            now += Math.max(1, nanoseconds / divisor);
            onPark.run();
        }
    }

    private FrameLoop loop(Timing timing, Pacing pacing) {
        return new FrameLoop(world, bus, timing, pacing, clock);
    }

    private void noteStarts() {
        long origin = clock.now;
        bus.subscribe(FramePhase.INTAKE, "starts", event -> starts.add(clock.now - origin));
    }

    @Test
    void whoWatchesSeesThePhaseAndWhetherTheLoopWaitsAsLongAsItMeantTo() {
        FrameLoop loop = loop(new Timing(60, 1), Pacing.REAL_TIME);
        List<String> seen = new ArrayList<>();
        for (FramePhase phase : FramePhase.values()) {
            bus.subscribe(
                    phase,
                    "watched",
                    event -> {
                        if (event.frame() == 1) {
                            seen.add(loop.phase() + (loop.isWaiting() ? " waits" : " works"));
                            assertThat(loop.thread()).isSameAs(Thread.currentThread());
                        }
                    });
        }
        clock.onPark =
                () -> {
                    seen.add(loop.phase() + (loop.isWaiting() ? " waits" : " works"));
                    clock.now += MILLISECOND;
                    seen.add(loop.isWaiting() ? "waits" : "is late");
                };
        loop.run(1);
        assertThat(seen)
                .containsExactly(
                        "INTAKE works",
                        "ACT works",
                        "PHYSICS works",
                        "DERIVE works",
                        "PUBLISH works",
                        "null waits",
                        "is late");
        assertThat(loop.thread()).isNull();

        loop.pause();
        seen.clear();
        clock.onPark =
                () -> {
                    clock.now += 1000 * MILLISECOND;
                    seen.add(loop.isWaiting() ? "waits" : "is late");
                    loop.stop();
                };
        loop.run(1);
        assertThat(seen).as("of a paused world").containsExactly("waits");
    }

    @Test
    void timeIsAProductOfTheNumberOfFrames() {
        var timing = new Timing(60, 4);
        assertThat(timing.dtSeconds()).isEqualTo(1.0 / 240);
        assertThat(timing.timeSeconds(300)).isEqualTo(1200 * (1.0 / 240));
        List<Double> times = new ArrayList<>();
        bus.subscribe(
                FramePhase.PHYSICS,
                "times",
                event -> {
                    assertThat(event.dtSeconds()).isEqualTo(1.0 / 240);
                    assertThat(event.steps()).isEqualTo(4);
                    assertThat(event.world()).isSameAs(world);
                    times.add(event.timeSeconds());
                });
        loop(timing, Pacing.FAST).run(3);
        assertThat(times).containsExactly(4 * (1.0 / 240), 8 * (1.0 / 240), 12 * (1.0 / 240));
    }

    @Test
    void timingRefusesWhatMakesNoTime() {
        assertThatIllegalArgumentException().isThrownBy(() -> new Timing(0, 1));
        assertThatIllegalArgumentException().isThrownBy(() -> new Timing(60, 0));
        assertThatIllegalArgumentException().isThrownBy(() -> new Timing(10_001, 1));
    }

    @Test
    void aSpeedChangesTheIntervalsButNotTheTimeOfTheWorld() {
        FrameLoop loop = loop(new Timing(50, 1), Pacing.REAL_TIME);
        noteStarts();
        List<Double> times = new ArrayList<>();
        bus.subscribe(
                FramePhase.ACT,
                "speed",
                event -> {
                    times.add(event.timeSeconds());
                    if (event.frame() == 3) {
                        loop.setSpeed(0.5);
                    } else if (event.frame() == 6) {
                        loop.setSpeed(4);
                    }
                });
        loop.run(9);
        List<Long> intervals = new ArrayList<>();
        for (int i = 1; i < starts.size(); i++) {
            intervals.add((starts.get(i) - starts.get(i - 1)) / 1_000_000);
        }
        assertThat(intervals).containsExactly(20L, 20L, 40L, 40L, 40L, 5L, 5L, 5L);
        for (int i = 0; i < times.size(); i++) {
            assertThat(times.get(i)).isEqualTo((i + 1) * 0.02);
        }
        assertThatIllegalArgumentException()
                .isThrownBy(() -> loop.setSpeed(0))
                .withMessageContaining("speed is 0.0");
    }

    @Test
    void realTimeStartsEveryFrameOnTheGridAndNeverDrifts() {
        noteStarts();
        bus.subscribe(FramePhase.PHYSICS, "work", event -> clock.now += 3 * MILLISECOND);
        clock.divisor = 3;
        FrameLoop loop = loop(new Timing(60, 1), Pacing.REAL_TIME);
        loop.run(601);
        for (int i = 0; i < 601; i++) {
            assertThat(starts.get(i)).isEqualTo(i * 1_000_000_000L / 60);
        }
        assertThat(loop.profile().overruns()).isZero();
        assertThat(loop.profile().droppedFrames()).isZero();
    }

    @Test
    void aShortStallIsCaughtUpWithoutLosingTime() {
        noteStarts();
        bus.subscribe(
                FramePhase.PHYSICS,
                "stall",
                event -> clock.now += event.frame() == 10 ? 50 * MILLISECOND : MILLISECOND);
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        loop.run(30);
        assertThat(starts.get(9)).isEqualTo(90 * MILLISECOND);
        assertThat(starts.get(10)).isEqualTo(140 * MILLISECOND);
        assertThat(starts.get(11)).isEqualTo(141 * MILLISECOND);
        assertThat(starts.get(20)).isEqualTo(200 * MILLISECOND);
        assertThat(loop.profile().overruns()).isEqualTo(5);
        assertThat(loop.profile().droppedFrames()).isZero();
    }

    @Test
    void aLongStallIsCaughtUpByFourFramesOnlyAndCounted() {
        noteStarts();
        bus.subscribe(
                FramePhase.PHYSICS,
                "stall",
                event -> clock.now += event.frame() == 1 ? 1000 * MILLISECOND : 0);
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        loop.run(12);
        long end = 1000 * MILLISECOND;
        assertThat(starts.stream().filter(start -> start == end)).hasSize(5);
        assertThat(starts.get(6)).isEqualTo(end + 10 * MILLISECOND);
        assertThat(starts.get(7)).isEqualTo(end + 20 * MILLISECOND);
        assertThat(loop.profile().droppedFrames()).isEqualTo(95);
    }

    @Test
    void overloadIsShownAndFramesGoOnBackToBack() {
        noteStarts();
        bus.subscribe(FramePhase.PHYSICS, "work", event -> clock.now += 20 * MILLISECOND);
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        loop.run(100);
        assertThat(starts.get(99)).isEqualTo(99 * 20 * MILLISECOND);
        assertThat(loop.profile().overruns()).isEqualTo(100);
        assertThat(loop.profile().droppedFrames()).isEqualTo(96);
    }

    @Test
    void itContinuesAfterAnyFrameWhichItPublishesFirst() {
        List<String> published = new ArrayList<>();
        bus.subscribe(
                FramePhase.PUBLISH,
                "notes",
                event -> published.add(event.frame() + " at " + event.timeSeconds()));
        FrameLoop loop = loop(new Timing(10, 1), Pacing.FAST);
        loop.run(2);
        loop.continueAfter(40);
        loop.run(1);
        assertThat(published)
                .containsExactly(
                        "0 at 0.0",
                        "1 at 0.1",
                        "2 at 0.2",
                        "40 at 0.2",
                        "41 at 0.30000000000000004");
        assertThat(loop.frame()).isEqualTo(41);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> loop.continueAfter(40))
                .withMessageContaining("frames never go back");
    }

    @Test
    void aFrameThatIsBeingMadeIsNotLeft() {
        FrameLoop loop = loop(new Timing(10, 1), Pacing.FAST);
        List<Throwable> refusals = new ArrayList<>();
        bus.subscribe(
                FramePhase.ACT,
                "jump",
                event -> refusals.add(catchThrowable(() -> loop.continueAfter(0))));
        loop.run(1);
        assertThat(refusals).singleElement().isInstanceOf(IllegalStateException.class);
        assertThat(loop.frame()).isEqualTo(1);
    }

    @Test
    void timeGoesBackWithTheWorldButFramesDoNot() {
        List<String> published = new ArrayList<>();
        bus.subscribe(
                FramePhase.PUBLISH,
                "notes",
                event -> published.add(event.frame() + " at " + event.timeSeconds()));
        FrameLoop loop = loop(new Timing(10, 1), Pacing.FAST);
        loop.run(1);
        try (WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, loop.frame());
            loop.run(2);
            loop.continueAfter(4);
            world.restore(image);
            loop.run(1);
        }
        assertThat(published)
                .containsExactly(
                        "0 at 0.0",
                        "1 at 0.1",
                        "2 at 0.2",
                        "3 at 0.30000000000000004",
                        "4 at 0.1",
                        "5 at 0.2");
    }

    @Test
    void anErrandIsRunBetweenFramesAtOnceWhileTheLoopWaitsOrIsPaused() {
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        noteStarts();
        List<String> done = new ArrayList<>();
        clock.divisor = 2;
        clock.onPark =
                () -> {
                    clock.onPark = () -> {};
                    loop.betweenFrames(
                            () -> {
                                done.add("waiting after " + loop.frame());
                                loop.pause();
                            });
                    clock.divisor = 1;
                    clock.onPark =
                            () -> {
                                if (loop.isPaused()) {
                                    clock.onPark = () -> {};
                                    loop.betweenFrames(
                                            () -> {
                                                done.add("paused after " + loop.frame());
                                                loop.resume();
                                            });
                                }
                            };
                };
        loop.run(3);
        assertThat(done).containsExactly("waiting after 1", "paused after 1");
        assertThat(loop.frame()).isEqualTo(3);
    }

    /** Otherwise clients that send many requests would stop the world. */
    @Test
    void manyErrandsDelayAFrameByTheirTimeOnly() {
        FrameLoop loop = loop(new Timing(60, 1), Pacing.REAL_TIME);
        noteStarts();
        var done = new int[1];
        for (int errand = 0; errand < 200; errand++) {
            loop.betweenFrames(
                    () -> {
                        clock.now += 4 * MILLISECOND;
                        done[0]++;
                    });
        }
        loop.run(40);
        for (int frame = 1; frame < starts.size(); frame++) {
            assertThat(starts.get(frame) - starts.get(frame - 1)).isLessThan(30 * MILLISECOND);
        }
        assertThat(done[0]).isBetween(100, 199);
        loop.run(60);
        assertThat(done[0]).isEqualTo(200);
    }

    @Test
    void aWorldThatAnErrandChangedIsPublishedThoughTheLoopIsPaused() {
        List<Long> published = new ArrayList<>();
        bus.subscribe(FramePhase.PUBLISH, "notes", event -> published.add(event.frame()));
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        loop.pause();
        clock.onPark =
                () -> {
                    clock.onPark = loop::stop;
                    loop.betweenFrames(() -> loop.continueAfter(1));
                };
        loop.run(10);
        assertThat(published).containsExactly(0L, 1L);
        assertThat(loop.isPaused()).isTrue();
    }

    @Test
    void fastNeverWaits() {
        noteStarts();
        FrameLoop loop = loop(new Timing(60, 1), Pacing.FAST);
        loop.run(1000);
        assertThat(starts).hasSize(1000).containsOnly(0L);
        assertThat(loop.frame()).isEqualTo(1000);
        assertThat(loop.profile().overruns()).isZero();
    }

    @Test
    void profileTellsWhereTheTimeWent() {
        bus.subscribe(FramePhase.ACT, "a", event -> clock.now += 10);
        bus.subscribe(FramePhase.PHYSICS, "x", event -> clock.now += 500);
        bus.subscribe(FramePhase.DERIVE, "d", event -> clock.now += event.frame() == 0 ? 0 : 7);
        FrameLoop loop = loop(new Timing(60, 1), Pacing.REAL_TIME);
        loop.run(20);
        FrameProfile profile = loop.profile();
        assertThat(profile.frames()).isEqualTo(20);
        assertThat(profile.busyNanoseconds()).isEqualTo(20 * 517);
        assertThat(profile.phaseNanoseconds())
                .containsEntry(FramePhase.INTAKE, 0L)
                .containsEntry(FramePhase.ACT, 200L)
                .containsEntry(FramePhase.PHYSICS, 10_000L)
                .containsEntry(FramePhase.DERIVE, 140L);
    }

    @Test
    void framesAreCountedByTheirDuration() {
        List<Long> durations =
                List.of(100_000L, 250_000L, 250_001L, 16 * MILLISECOND, 3_000_000_000L);
        bus.subscribe(
                FramePhase.PHYSICS,
                "x",
                event -> clock.now += durations.get((int) event.frame() - 1));
        FrameLoop loop = loop(new Timing(60, 1), Pacing.FAST);
        loop.run(durations.size());
        List<Long> counts = loop.profile().framesByTime();
        assertThat(counts).hasSize(FrameProfile.TIME_BOUNDS_SECONDS.size() + 1);
        assertThat(counts.get(0)).isEqualTo(2);
        assertThat(counts.get(1)).isEqualTo(1);
        assertThat(counts.get(FrameProfile.TIME_BOUNDS_SECONDS.indexOf(0.016))).isEqualTo(1);
        assertThat(counts.getLast()).isEqualTo(1);
        assertThat(counts.stream().mapToLong(Long::longValue).sum()).isEqualTo(durations.size());
        assertThat(FrameProfile.TIME_BOUNDS_SECONDS).isSorted();
    }

    @Test
    void stopFromAnotherThreadEndsTheRunForGood() throws InterruptedException {
        var loop = new FrameLoop(world, bus, new Timing(1, 1), Pacing.REAL_TIME);
        Thread runner = new Thread(loop::run);
        bus.subscribe(
                FramePhase.PUBLISH,
                "stopper",
                event -> {
                    if (event.frame() == 1) {
                        new Thread(loop::stop).start();
                    }
                });
        runner.start();
        runner.join(60_000);
        assertThat(runner.isAlive()).isFalse();
        world.guard().claim();
        long frame = loop.frame();
        loop.run(5);
        assertThat(loop.frame()).isEqualTo(frame);
        loop.step();
        assertThat(loop.frame()).isEqualTo(frame + 1);
    }

    @Test
    void anInterruptedThreadEndsTheRunAndStaysInterrupted() {
        bus.subscribe(FramePhase.ACT, "interrupter", event -> Thread.currentThread().interrupt());
        FrameLoop loop = loop(new Timing(60, 1), Pacing.REAL_TIME);
        loop.run(5);
        assertThat(Thread.interrupted()).isTrue();
        assertThat(loop.frame()).isEqualTo(1);
    }

    @Test
    void theThreadThatRunsTheLoopOwnsTheWorld() throws InterruptedException {
        List<Boolean> found = new ArrayList<>();
        bus.subscribe(
                FramePhase.ACT,
                "finder",
                event -> found.add(event.world().find("world").isPresent()));
        Thread runner = new Thread(() -> loop(Timing.DEFAULT, Pacing.FAST).run(1));
        runner.start();
        runner.join();
        assertThat(found).containsExactly(true);
    }

    @Test
    void aPausedLoopMakesExactlyTheFramesItIsToldToAndTimeGoesOnWithoutAJump() {
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        noteStarts();
        var script =
                new ArrayList<Runnable>(
                        List.of(
                                () -> assertThat(loop.resume(2)).isEqualTo(5),
                                () -> assertThat(loop.resume(1)).isEqualTo(6),
                                loop::resume));
        bus.subscribe(
                FramePhase.PUBLISH,
                "operator",
                event -> {
                    if (event.frame() == 3) {
                        assertThat(loop.pause()).isEqualTo(3);
                    }
                });
        clock.onPark =
                () -> {
                    if (loop.isPaused() && !script.isEmpty()) {
                        script.removeFirst().run();
                    }
                };
        loop.run(10);
        assertThat(loop.frame()).isEqualTo(10);
        assertThat(script).isEmpty();
        assertThat(loop.profile().overruns()).isZero();
        assertThat(starts.get(9) - starts.get(7)).isEqualTo(20 * MILLISECOND);
    }

    /** A client that resumes a paused world must not end a suspension. */
    @Test
    void aSuspendedLoopMakesNoFramesUntilTheSuspensionEnds() {
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        noteStarts();
        List<String> done = new ArrayList<>();
        var script =
                new ArrayList<Runnable>(
                        List.of(
                                loop::pause,
                                loop::resume,
                                () -> loop.betweenFrames(() -> done.add("after " + loop.frame())),
                                () -> loop.suspend(false)));
        bus.subscribe(
                FramePhase.PUBLISH,
                "server",
                event -> {
                    if (event.frame() == 3) {
                        loop.suspend(true);
                    }
                });
        clock.onPark =
                () -> {
                    if (loop.isSuspended()) {
                        assertThat(loop.frame()).isEqualTo(3);
                        script.removeFirst().run();
                    }
                };
        loop.run(10);
        assertThat(loop.frame()).isEqualTo(10);
        assertThat(done).containsExactly("after 3");
        assertThat(loop.profile().overruns()).isZero();
    }

    @Test
    void aSuspendedLoopStops() {
        FrameLoop loop = loop(new Timing(100, 1), Pacing.REAL_TIME);
        loop.suspend(true);
        clock.onPark = loop::stop;
        loop.run(10);
        assertThat(loop.frame()).isZero();
    }
}
