// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Random;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicLong;

class CommandQueueTest {

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
    private final List<String> done = new ArrayList<>();

    private record Note(String origin, long sequence, List<String> into) implements Command {
        @Override
        public void execute(World world, FrameEvent event) {
            assertThat(event.phase()).isEqualTo(FramePhase.ACT);
            into.add(origin + sequence);
        }
    }

    private CommandQueue queue(int capacity) {
        var queue = new CommandQueue(capacity);
        queue.subscribeTo(bus);
        return queue;
    }

    @Test
    void orderDependsOnOriginAndSequenceNotOnArrival() {
        long seed = Seed.of("arrivals");
        CommandQueue queue = queue(100);
        List<Command> commands = new ArrayList<>();
        List<String> expected = new ArrayList<>();
        for (String origin : List.of("ada", "bob", "laws-folder")) {
            for (int i = 1; i <= 20; i++) {
                commands.add(new Note(origin, i, done));
                expected.add(origin + i);
            }
        }
        var random = new Random(seed);
        for (int round = 0; round < 10; round++) {
            Collections.shuffle(commands, random);
            done.clear();
            commands.forEach(command -> assertThat(queue.offer(command)).isTrue());
            loop.step();
            assertThat(done).as("seed %d", seed).isEqualTo(expected);
        }
    }

    @Test
    void aCommandIsExecutedOnceInTheNextFrame() {
        CommandQueue queue = queue(10);
        queue.offer(new Note("a", 1, done));
        loop.step();
        loop.step();
        assertThat(done).containsExactly("a1");
    }

    @Test
    void whatIsOfferedDuringAFrameBelongsToTheNext() {
        CommandQueue queue = queue(10);
        bus.subscribe(
                FramePhase.ACT, "late", event -> queue.offer(new Note("f", event.frame(), done)));
        loop.step();
        assertThat(done).isEmpty();
        loop.step();
        assertThat(done).containsExactly("f1");
    }

    @Test
    void aFullQueueRefusesUntilAFrameTookItsCommands() {
        assertThatIllegalArgumentException().isThrownBy(() -> new CommandQueue(0));
        CommandQueue queue = queue(2);
        assertThat(queue.offer(new Note("a", 1, done))).isTrue();
        assertThat(queue.offer(new Note("a", 2, done))).isTrue();
        assertThat(queue.offer(new Note("a", 3, done))).isFalse();
        loop.step();
        assertThat(done).containsExactly("a1", "a2");
        assertThat(queue.offer(new Note("a", 4, done))).isTrue();
    }

    @Test
    void aThrowingCommandHarmsNoOtherAndIsReported() {
        List<WorldEvent> faults = new ArrayList<>();
        bus.subscribe(FramePhase.PUBLISH, "reader", event -> faults.addAll(event.world().events()));
        CommandQueue queue = queue(10);
        queue.offer(new Note("a", 1, done));
        queue.offer(
                new Command() {
                    @Override
                    public String origin() {
                        return "a";
                    }

                    @Override
                    public long sequence() {
                        return 2;
                    }

                    @Override
                    public void execute(World ignored, FrameEvent event) {
                        throw new IllegalArgumentException("no such thing");
                    }
                });
        queue.offer(new Note("a", 3, done));
        loop.step();
        assertThat(done).containsExactly("a1", "a3");
        assertThat(faults)
                .singleElement()
                .satisfies(
                        fault ->
                                assertThat(fault.fields())
                                        .containsEntry("source", "command of a")
                                        .containsEntry("message", "no such thing"));
    }

    /** A command that is executed once per frame. */
    private final class Slow implements Command {
        private final String origin;
        private final long sequence;

        Slow(String origin, long sequence) {
            this.origin = origin;
            this.sequence = sequence;
        }

        @Override
        public String origin() {
            return origin;
        }

        @Override
        public long sequence() {
            return sequence;
        }

        @Override
        public boolean mustWait(FrameEvent event) {
            return done.contains(origin + "@" + event.frame());
        }

        @Override
        public void execute(World ignored, FrameEvent event) {
            done.add(origin + sequence);
            done.add(origin + "@" + event.frame());
        }
    }

    @Test
    void whatMustWaitIsExecutedInLaterFramesInItsOrderAndBeforeWhatFollows() {
        CommandQueue queue = queue(10);
        queue.offer(new Slow("a", 1));
        queue.offer(new Slow("a", 2));
        queue.offer(new Note("a", 3, done));
        queue.offer(new Note("b", 4, done));
        queue.offer(new Slow("c", 5));
        loop.step();
        assertThat(done).containsExactly("a1", "a@1", "b4", "c5", "c@1");
        done.clear();
        queue.offer(new Slow("a", 6));
        loop.step();
        assertThat(done).containsExactly("a2", "a@2", "a3");
        done.clear();
        loop.step();
        assertThat(done).containsExactly("a6", "a@3");
    }

    /** A command that advances the time of the queue when it is executed. */
    private record Costly(
            String origin,
            long sequence,
            boolean isPrompt,
            long nanoseconds,
            AtomicLong time,
            List<String> into)
            implements Command {
        @Override
        public boolean isCostly() {
            return true;
        }

        @Override
        public void execute(World world, FrameEvent event) {
            time.addAndGet(nanoseconds);
            into.add(origin + sequence);
        }
    }

    @Test
    void costlyCommandsWaitIfTheirTimeIsUsedAndOthersDoNot() {
        var time = new AtomicLong();
        var queue = new CommandQueue(10, time::get);
        queue.subscribeTo(bus);
        queue.offer(new Costly("a", 1, false, 24_000_000, time, done));
        queue.offer(new Costly("a", 2, false, 60_000_000_000L, time, done));
        queue.offer(new Costly("a", 3, false, 1, time, done));
        queue.offer(new Note("a", 4, done));
        queue.offer(new Note("b", 5, done));
        queue.offer(new Costly("c", 6, false, 1, time, done));
        loop.step();
        assertThat(done).containsExactly("a1", "a2", "b5");
        loop.step();
        assertThat(done).containsExactly("a1", "a2", "b5", "a3", "a4", "c6");
    }

    @Test
    void costlyPromptCommandsRemainUntilTheNextGap() {
        var time = new AtomicLong();
        var queue = new CommandQueue(3, time::get);
        queue.subscribeTo(bus);
        for (int i = 1; i <= 3; i++) {
            queue.offer(new Costly("a", i, true, 30_000_000, time, done));
        }
        assertThat(loop.executePrompt(queue)).isTrue();
        assertThat(done).containsExactly("a1");
        assertThat(queue.offer(new Note("b", 4, done))).isTrue();
        assertThat(queue.offer(new Note("b", 5, done))).as("a2, a3 and b4 wait").isFalse();
        assertThat(loop.executePrompt(queue)).isTrue();
        assertThat(loop.executePrompt(queue)).isFalse();
        assertThat(done).containsExactly("a1", "a2", "a3");
        loop.step();
        assertThat(done).containsExactly("a1", "a2", "a3", "b4");
    }

    @Test
    void whatMustWaitHasItsPlaceInTheQueue() {
        CommandQueue queue = queue(2);
        queue.offer(new Slow("a", 1));
        queue.offer(new Slow("a", 2));
        loop.step();
        assertThat(queue.offer(new Note("b", 3, done))).isTrue();
        assertThat(queue.offer(new Note("b", 4, done))).as("a2 waits").isFalse();
        loop.step();
        assertThat(queue.offer(new Note("b", 5, done))).isTrue();
        assertThat(queue.offer(new Note("b", 6, done))).isTrue();
    }

    @Test
    void manyThreadsLoseAndDuplicateNothing() throws Exception {
        CommandQueue queue = queue(64);
        var refused = new AtomicInteger();
        try (ExecutorService senders = Executors.newFixedThreadPool(4)) {
            List<Future<?>> all = new ArrayList<>();
            for (String origin : List.of("a", "b", "c", "d")) {
                all.add(
                        senders.submit(
                                () -> {
                                    for (int i = 0; i < 2000; i++) {
                                        while (!queue.offer(new Note(origin, i, done))) {
                                            refused.incrementAndGet();
                                            Thread.onSpinWait();
                                        }
                                    }
                                }));
            }
            while (!all.stream().allMatch(Future::isDone)) {
                loop.step();
            }
            for (Future<?> one : all) {
                one.get();
            }
        }
        loop.step();
        assertThat(done).hasSize(8000).doesNotHaveDuplicates();
        List<String> ofA = done.stream().filter(note -> note.startsWith("a")).toList();
        for (int i = 0; i < 2000; i++) {
            assertThat(ofA.get(i)).isEqualTo("a" + i);
        }
    }
}
