// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.image.CorruptException;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.ArrayList;
import java.util.List;
import java.util.Random;
import java.util.UUID;
import java.util.zip.CRC32C;

class RunLogTest {
    private static final int MEBIBYTE = 1 << 20;

    @TempDir private Path folder;

    /** Holes take no space on the disk, so a file of any size is easy to make. */
    @Test
    void aSparseFileWithAWrongSumTakesNoMemory() throws IOException {
        for (int length : List.of(256 * MEBIBYTE, RunLog.MAX_BYTES + 1, Integer.MAX_VALUE - 15)) {
            for (char letter : "LIF".toCharArray()) {
                Path file = sparse(letter, length);
                long before = allocated();
                assertThatExceptionOfType(CorruptException.class)
                        .isThrownBy(() -> RunLog.open(file).next())
                        .withMessage(
                                file
                                        + " is damaged in the record at byte 15; nothing after "
                                        + "it can be trusted");
                assertThat(allocated() - before).isLessThan(4 * MEBIBYTE);
            }
        }
    }

    @Test
    void aLargeRecordComesBack() throws IOException {
        Path file = folder.resolve("run.log");
        byte[] large = new byte[3 * MEBIBYTE + 5];
        new Random(1).nextBytes(large);
        try (Recording recording = new Recording(RecordingPlan.of(file))) {
            recording.write(new JournalRecord.Frame(1, large));
            recording.write(new JournalRecord.Frame(2, new byte[3]));
        }
        List<JournalRecord> read = new ArrayList<>();
        try (RunLog.Reader reader = RunLog.open(file)) {
            reader.forEachRemaining(read::add);
        }
        assertThat(read).hasSize(2);
        assertThat(((JournalRecord.Frame) read.getFirst()).json()).isEqualTo(large);
        try (FileChannel channel = FileChannel.open(file, StandardOpenOption.WRITE)) {
            channel.write(
                    ByteBuffer.wrap(new byte[] {(byte) ~large[MEBIBYTE]}),
                    RunLog.EMPTY_BYTES + 17 + MEBIBYTE);
        }
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> RunLog.open(file).next())
                .withMessageContaining("damaged in the record at byte 15");
    }

    /** A recording has the name that a store needs for its next file of frames. */
    @Test
    void aStoreDoesNotWriteOverARecordingInUse() throws IOException {
        Path file = folder.resolve("s.db-frames-2");
        try (Recording recording = new Recording(RecordingPlan.of(file))) {
            recording.write(new JournalRecord.Frame(1, new byte[3]));
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(
                            () -> new RunLog.Writer(file, new RunLog.Link(new UUID(1, 1), 2, 3, 4)))
                    .withMessageContaining("is in use");
        }
        assertThat(RunLog.open(file).next()).isInstanceOf(JournalRecord.Frame.class);
    }

    @Test
    void theLastFrameIsKnownBeforeTheRecordsAreRead() throws IOException {
        Path file = folder.resolve("run.log");
        try (Recording recording = new Recording(RecordingPlan.of(file))) {
            for (int frame = 1; frame <= 40; frame++) {
                recording.write(new JournalRecord.Frame(frame, new byte[100 * frame]));
            }
        }
        try (RunLog.Reader reader = RunLog.open(file)) {
            assertThat(reader.lastFrame()).isEqualTo(40);
            reader.forEachRemaining(read -> {});
        }
        try (FileChannel channel = FileChannel.open(file, StandardOpenOption.WRITE)) {
            channel.truncate(channel.size() - 1); // like a crash
            channel.write(ByteBuffer.allocate(1), channel.size() + MEBIBYTE);
        }
        try (RunLog.Reader reader = RunLog.open(file)) {
            assertThat(reader.lastFrame()).isEqualTo(40);
        }
        Path damaged = sparse('I', Integer.MAX_VALUE - 15);
        try (RunLog.Reader reader = RunLog.open(damaged)) {
            assertThat(reader.lastFrame()).isZero();
        }
    }

    private Path sparse(char letter, int length) throws IOException {
        Path file = folder.resolve(letter + "-" + length + ".log");
        ByteBuffer head =
                ByteBuffer.allocate(13)
                        .order(ByteOrder.LITTLE_ENDIAN)
                        .putInt(length)
                        .put((byte) letter)
                        .putLong(0)
                        .flip();
        var crc = new CRC32C();
        crc.update(head.duplicate());
        ByteBuffer start =
                ByteBuffer.allocate(RunLog.EMPTY_BYTES + 17)
                        .order(ByteOrder.LITTLE_ENDIAN)
                        .put("REVE run log 2\n".getBytes())
                        .put(head)
                        .putInt((int) crc.getValue());
        Files.write(file, start.array());
        try (FileChannel channel = FileChannel.open(file, StandardOpenOption.WRITE)) {
            channel.write(ByteBuffer.allocate(1), 4L + start.capacity() + length);
        }
        return file;
    }

    private static long allocated() {
        return ((com.sun.management.ThreadMXBean) ManagementFactory.getThreadMXBean())
                .getCurrentThreadAllocatedBytes();
    }

    /** A run that resumes at frame 180 and keeps nothing has not lost the frames before it. */
    @Test
    void aRunThatKeepsNothingLosesItsOwnFrames() {
        assertThat(new Journal.Shortfall(-1, 181, 260).toString())
                .endsWith("nothing of this run, frames 181 to 260 are lost");
        assertThat(new Journal.Shortfall(200, 181, 260).toString())
                .endsWith("continues from frame 200, frames 201 to 260 are lost");
    }
}
