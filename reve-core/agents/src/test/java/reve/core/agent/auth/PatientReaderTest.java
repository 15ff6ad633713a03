// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIOException;

import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.nio.file.Path;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicInteger;

/** Files that give no data. */
class PatientReaderTest {
    private static final Path FILE = Path.of("tokens.json");

    private final CountDownLatch answers = new CountDownLatch(1);
    private final AtomicInteger begun = new AtomicInteger();

    private String readSlowly() {
        begun.incrementAndGet();
        while (true) { // as a system call that cannot be interrupted
            try {
                answers.await();
                return "late";
            } catch (InterruptedException ignored) {
                // Continues to wait.
            }
        }
    }

    @Test
    void aFileThatGivesNoDataIsWaitedForOnce() throws Exception {
        var reader = new PatientReader(FILE, TimeUnit.HOURS.toNanos(1));
        for (int i = 0; i < 3; i++) {
            assertThatExceptionOfType(PatientReader.SlowException.class)
                    .isThrownBy(() -> reader.read(this::readSlowly))
                    .withMessageContaining("tokens.json gives no data");
        }
        assertThat(begun).hasValue(1);
        answers.countDown();
        // From here on, the thread of the first reading may end at any time.
        String result = null;
        while (result == null) {
            try {
                result = reader.read(() -> "now");
            } catch (PatientReader.SlowException notYet) {
                Thread.onSpinWait();
            }
        }
        assertThat(result).isEqualTo("now");
    }

    @Test
    void threadsThatAreGivenUpAreLimited() throws Exception {
        var reader = new PatientReader(FILE, 0);
        for (int i = 0; i < 12; i++) {
            assertThatExceptionOfType(PatientReader.SlowException.class)
                    .isThrownBy(() -> reader.read(this::readSlowly));
        }
        assertThat(begun).hasValue(9); // one still reads, and the reader gave eight up
        answers.countDown();
    }

    @Test
    void aReadingThatFailsFailsWithItsOwnException() throws Exception {
        var reader = new PatientReader(FILE);
        assertThatIOException()
                .isThrownBy(
                        () ->
                                reader.read(
                                        () -> {
                                            throw new IOException("no such file");
                                        }))
                .withMessage("no such file");
        assertThat(reader.<Integer>read(() -> 3)).isEqualTo(3);
    }
}
