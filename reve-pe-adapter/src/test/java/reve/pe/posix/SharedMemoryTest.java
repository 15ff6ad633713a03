// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;

class SharedMemoryTest {
    @Test
    void bytesWrittenHereAreReadThroughTheDescriptor() throws IOException {
        try (SharedMemory memory = new SharedMemory("test", 10_000)) {
            memory.segment().set(ValueLayout.JAVA_LONG, 9_992, 0x0123456789ABCDEFL);
            try (FileChannel other = FileChannel.open(file(memory), StandardOpenOption.READ)) {
                assertThat(other.size()).isEqualTo(10_000);
                ByteBuffer tail = ByteBuffer.allocate(8).order(ByteOrder.nativeOrder());
                other.read(tail, 9_992);
                assertThat(tail.getLong(0)).isEqualTo(0x0123456789ABCDEFL);
            }
        }
    }

    @Test
    void bytesWrittenThroughTheDescriptorAreSeenHere() throws IOException {
        try (SharedMemory memory = new SharedMemory("test", 4096);
                FileChannel other = FileChannel.open(file(memory), StandardOpenOption.WRITE)) {
            other.write(ByteBuffer.wrap(new byte[] {42}), 7);
            assertThat(memory.segment().get(ValueLayout.JAVA_BYTE, 7)).isEqualTo((byte) 42);
        }
    }

    @Test
    void anotherProcessReadsTheSameBytes() throws Exception {
        try (SharedMemory memory = new SharedMemory("test", 5)) {
            MemorySegment.copy(
                    "hello".getBytes(), 0, memory.segment(), ValueLayout.JAVA_BYTE, 0, 5);
            Process other =
                    new ProcessBuilder(
                                    "cat",
                                    "/proc/"
                                            + ProcessHandle.current().pid()
                                            + "/fd/"
                                            + memory.descriptor())
                            .start();
            assertThat(other.getInputStream().readAllBytes()).asString().isEqualTo("hello");
            assertThat(other.waitFor()).isZero();
        }
    }

    @Test
    void memoryIsZeroedAndPageAligned() {
        try (SharedMemory memory = new SharedMemory("test", 3 * 4096)) {
            assertThat(memory.segment().address() % 4096).isZero();
            assertThat(memory.segment().toArray(ValueLayout.JAVA_LONG)).containsOnly(0);
        }
    }

    @Test
    void closingFreesDescriptorAndMappingOnce() throws IOException {
        SharedMemory memory = new SharedMemory("gone-after-close", 4096);
        MemorySegment segment = memory.segment();
        assertThat(mappings()).contains("memfd:gone-after-close");
        memory.close();
        memory.close();
        assertThat(mappings()).doesNotContain("memfd:gone-after-close");
        assertThatIllegalStateException().isThrownBy(() -> segment.get(ValueLayout.JAVA_BYTE, 0));
    }

    @Test
    void whatTheSystemRefusesIsNamed() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new SharedMemory("test", 0))
                .withMessage("shared memory 'test': 0 bytes, expected at least 1");
        assertThatIllegalStateException()
                .isThrownBy(() -> new SharedMemory("test", Long.MAX_VALUE))
                .withMessageStartingWith("shared memory 'test': ")
                .withMessageContaining("failed: ");
        assertThatIllegalStateException()
                .isThrownBy(() -> new SharedMemory("n".repeat(250), 1))
                .withMessageContaining("memfd_create failed: Invalid argument (errno 22)");
    }

    @Test
    void aLimitThatIsReachedIsNamedInWords() {
        assertThat(SharedMemory.reason(24))
                .isEqualTo(
                        "Too many open files (errno 24); raise the "
                                + "limit of open files of the process (ulimit -n)");
        assertThat(SharedMemory.reason(12)).startsWith("Cannot allocate memory (errno 12); make ");
    }

    private static String mappings() throws IOException {
        return Files.readString(Path.of("/proc/self/maps"));
    }

    private static Path file(SharedMemory memory) {
        return Path.of("/proc/self/fd/" + memory.descriptor());
    }
}
