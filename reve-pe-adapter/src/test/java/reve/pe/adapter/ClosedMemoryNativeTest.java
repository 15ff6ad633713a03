// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.List;
import java.util.Random;
import java.util.concurrent.Callable;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.atomic.AtomicReference;

/** Column memory that is used wrongly: out of bounds, and while another thread releases it. */
@Timeout(value = 300, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class ClosedMemoryNativeTest {
    private static final int THREADS = 8;

    /** Number of uses by all threads. The fault model requires 1,000,000. */
    private static final int USES = Integer.getInteger("reve.test.memory.uses", 100_000);

    private static final long BYTES = 4096;

    /** What the uses of a thread led to. */
    private record Outcome(int done, int refused) {}

    @Test
    void everyWrongUseIsAnExceptionAndNoneEndsTheProcess() throws Exception {
        try (SharedArena arena = new SharedArena();
                ExecutorService threads = Executors.newFixedThreadPool(THREADS)) {
            AtomicReference<MemorySegment> memory =
                    new AtomicReference<>(arena.reserve("column", BYTES));
            List<Future<Outcome>> users = new ArrayList<>();
            for (int thread = 0; thread < THREADS; thread++) {
                users.add(threads.submit(user(memory, new Random(thread))));
            }
            while (users.stream().anyMatch(user -> !user.isDone())) {
                MemorySegment old = memory.getAndSet(arena.reserve("column", BYTES));
                arena.release(old);
            }
            int done = 0;
            int refused = 0;
            for (Future<Outcome> user : users) {
                done += user.get().done;
                refused += user.get().refused;
            }
            assertThat(done + refused).isEqualTo(USES / THREADS * THREADS);
            assertThat(done).isPositive();
            assertThat(refused).isPositive();
        }
    }

    private static Callable<Outcome> user(AtomicReference<MemorySegment> memory, Random random) {
        return () -> {
            int done = 0;
            int refused = 0;
            MemorySegment own = memory.get();
            for (int use = 0; use < USES / THREADS; use++) {
                try {
                    if (random.nextInt(4) == 0) {
                        own = memory.get(); // otherwise perhaps memory that is closed
                    }
                    use(own, random);
                    done++;
                } catch (IllegalStateException | IndexOutOfBoundsException expected) {
                    refused++;
                }
            }
            return new Outcome(done, refused);
        };
    }

    private static void use(MemorySegment memory, Random random) {
        long place = random.nextLong(2 * BYTES) - BYTES / 2;
        switch (random.nextInt(5)) {
            case 0 -> memory.get(ValueLayout.JAVA_DOUBLE_UNALIGNED, place);
            case 1 -> memory.set(ValueLayout.JAVA_LONG_UNALIGNED, place, place);
            case 2 -> memory.asSlice(place, random.nextLong(BYTES)).fill((byte) 7);
            case 3 -> MemorySegment.copy(memory, 0, memory, place, BYTES / 2);
            default -> memory.mismatch(memory.asSlice(place));
        }
    }
}
