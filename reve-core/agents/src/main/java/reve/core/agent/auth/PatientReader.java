// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import org.jspecify.annotations.Nullable;

import java.io.IOException;
import java.nio.file.FileSystemException;
import java.nio.file.Path;
import java.util.concurrent.CancellationException;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.FutureTask;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;

/**
 * Reads a file on separate threads. Such a thread may block, for example because a network disk
 * does not answer. The first call then waits for {@link #PATIENCE_MILLIS} and fails. Each further
 * call fails at once until the file can be read again. For one thread at a time.
 */
final class PatientReader {

    /** Time that a caller waits for a file [ms]. */
    static final long PATIENCE_MILLIS = 500;

    /** Time after which the reader abandons a blocked thread and may start another one [ns]. */
    private static final long GIVE_UP_NANOS = TimeUnit.SECONDS.toNanos(10);

    /** Maximum number of abandoned threads that have not ended. */
    private static final int MOST_GIVEN_UP = 8;

    /** The operation that reads the file and may block. */
    interface Reading<T> {
        T read() throws IOException;
    }

    /** Reports that reading a file has not ended in time. */
    static final class SlowException extends FileSystemException {
        private static final long serialVersionUID = 1;

        SlowException(Path path) {
            super(
                    path
                            + " gives no data for more than "
                            + PATIENCE_MILLIS
                            + " ms: expected a file on a disk that answers; see whether another"
                            + " program or a network disk blocks it");
        }
    }

    private final Path path;
    private final long giveUpNanos;

    /** The read operation that has not ended in time; null if there is none. */
    private @Nullable FutureTask<?> late;

    private long lateSinceNanos;
    private final Thread[] givenUp = new Thread[MOST_GIVEN_UP];
    private @Nullable Thread thread;

    /**
     * @param path the file, which error messages name
     */
    PatientReader(Path path) {
        this(path, GIVE_UP_NANOS);
    }

    /** Creates a reader that abandons blocked threads after another time; for tests. */
    PatientReader(Path path, long giveUpNanos) {
        this.path = path;
        this.giveUpNanos = giveUpNanos;
    }

    /**
     * Runs the read operation on another thread and returns its result.
     *
     * @throws SlowException if the operation does not end in time, or an earlier one has not ended
     * @throws IOException if the operation fails
     */
    <T> T read(Reading<T> reading) throws IOException {
        if (late != null && !late.isDone() && !isGivenUp()) {
            throw new SlowException(path);
        }
        var task = new FutureTask<T>(reading::read);
        late = task;
        lateSinceNanos = System.nanoTime();
        thread = Thread.ofPlatform().daemon().name("file reader").start(task);
        try {
            T result = task.get(PATIENCE_MILLIS, TimeUnit.MILLISECONDS);
            late = null;
            return result;
        } catch (ExecutionException failed) {
            late = null;
            if (failed.getCause() instanceof IOException cause) {
                throw cause;
            }
            throw new IOException(path + " cannot be read: " + failed.getCause(), failed);
        } catch (TimeoutException | CancellationException slow) {
            throw new SlowException(path);
        } catch (InterruptedException ending) {
            Thread.currentThread().interrupt();
            throw new SlowException(path);
        }
    }

    /**
     * Interrupts and abandons a thread that has been blocked for a long time. Returns whether
     * another thread may read the file now.
     */
    private boolean isGivenUp() {
        if (System.nanoTime() - lateSinceNanos < giveUpNanos) {
            return false;
        }
        for (int i = 0; i < MOST_GIVEN_UP; i++) {
            if (givenUp[i] == null || !givenUp[i].isAlive()) {
                givenUp[i] = thread;
                late.cancel(true);
                return true;
            }
        }
        return false;
    }
}
