// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;

import java.io.IOException;
import java.nio.file.Path;
import java.util.Map;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.Semaphore;

/** A journal whose sink accepts nothing for a while, and gives no answer to a write of an image. */
@Timeout(value = 600, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class SilentSinkNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "spring-orbit", "world.yaml");
    private static final int IMAGE_FRAMES = 5;

    private final Queue<String> problems = new ConcurrentLinkedQueue<>();
    private final Semaphore answers = new Semaphore(0);
    private volatile boolean isAway;

    @Test
    void framesDoNotWaitForImagesOfAFailedJournal() throws Exception {
        try (Simulation simulation =
                        new Simulation(WorldFile.load(WORLD), Pacing.FAST, LawPath.ofShipped());
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(IMAGE_FRAMES, false),
                                new Sink(),
                                problems::add)) {
            simulation.loop().run(3);
            isAway = true;
            simulation.loop().run(10 * IMAGE_FRAMES); // with an image that waits for an answer
            assertThat(problems)
                    .as("the frame that was not written, and no report of a slow disk")
                    .singleElement()
                    .asString()
                    .contains("no answer", "loses the frames from");
            isAway = false;
            answers.release(Integer.MAX_VALUE);
            while (problems.stream().noneMatch(line -> line.contains("complete again"))) {
                simulation.loop().step();
            }
        }
    }

    private final class Sink implements JournalSink {
        @Override
        public void write(JournalRecord record) throws IOException {
            if (isAway) {
                throw new IOException("no answer");
            }
        }

        @Override
        public Place place() {
            return (libraries, image) -> {
                if (isAway) {
                    answers.acquireUninterruptibly();
                    throw new IOException("no answer");
                }
            };
        }

        @Override
        public void sync() {
            // nothing outlives this process
        }

        @Override
        public void close() {
            // nothing is open
        }
    }
}
