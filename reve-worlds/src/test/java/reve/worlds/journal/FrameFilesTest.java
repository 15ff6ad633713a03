package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

class FrameFilesTest {
    @TempDir
    private Path folder;
    private Path store;
    private final List<String> problems = new ArrayList<>();

    @BeforeEach
    void name() {
        store = folder.resolve("my.db");
    }

    @Test
    void framesAreReadFromOneFileOn() throws IOException {
        fill();
        assertThat(read(1)).containsExactly(1L, 2L, 3L, 4L, 5L, 6L);
        assertThat(read(2)).containsExactly(3L, 4L, 5L, 6L);
        assertThat(read(4)).isEmpty();
    }

    @Test
    void whatIsWrittenLaterGoesBehindAllThatIsThere() throws IOException {
        fill();
        FrameFiles again = new FrameFiles(store, 1);
        try (FrameFiles.Finished _ = again.next()) {
            assertThat(again.number()).isEqualTo(4);
        }
    }

    @Test
    void filesBeforeTheOldestImageAreRemovedAndNothingElse() throws IOException {
        fill();
        Files.writeString(folder.resolve("my.db-frames-old"), "mine");
        new FrameFiles(store, 0).dropBefore(3);
        assertThat(read(1)).containsExactly(5L, 6L);
        assertThat(folder.resolve("my.db-frames-old")).exists();
    }

    /** As after a crash, whatever was the last byte that was written. */
    @Test
    void aFileThatEndsAnywhereIsReadUpToItsLastWholeFrame() throws IOException {
        fill();
        Path last = folder.resolve("my.db-frames-3");
        byte[] whole = Files.readAllBytes(last);
        int second = (whole.length + RunLog.EMPTY_BYTES) / 2;
        for (int length = 0; length <= whole.length; length++) {
            Files.write(last, Arrays.copyOf(whole, length));
            assertThat(read(3)).as("cut at byte %d", length).containsExactlyElementsOf(
                    length < second ? List.of() : length < whole.length ? List.of(5L)
                            : List.of(5L, 6L));
            assertThat(problems).as("cut at byte %d", length).isEmpty();
        }
    }

    /** Every bit in turn: the frames before it are read, and somebody is told. */
    @Test
    void aDamagedFrameIsToldAndEndsTheJournal() throws IOException {
        fill();
        Path damaged = folder.resolve("my.db-frames-2");
        byte[] whole = Files.readAllBytes(damaged);
        int first = RunLog.EMPTY_BYTES;
        int second = (whole.length + first) / 2;
        for (int bit = 0; bit < 8 * whole.length; bit++) {
            byte[] bytes = whole.clone();
            bytes[bit / 8] ^= (byte) (1 << bit % 8);
            Files.write(damaged, bytes);
            problems.clear();
            assertThat(read(1)).as("bit %d", bit).containsExactlyElementsOf(
                    bit / 8 < second ? List.of(1L, 2L) : List.of(1L, 2L, 3L));
            assertThat(problems).as("bit %d", bit).singleElement().asString()
                    .startsWith(damaged.toString()).contains(bit / 8 < first ? "no recording"
                            : "at byte " + (bit / 8 < second ? first : second));
        }
    }

    @Test
    void whatCannotBeWrittenIsToldByNameAndReason() throws IOException {
        FrameFiles files = new FrameFiles(store, 0);
        Files.createDirectory(folder.resolve("my.db-frames-1"));
        try (FrameFiles.Finished _ = files.next()) {
            assertThatExceptionOfType(IOException.class).isThrownBy(() -> files.write(frame(1)))
                    .withMessageContaining("my.db-frames-1 could not be written: Is a directory");
        }
    }

    /** Six frames in three files. */
    private void fill() throws IOException {
        FrameFiles files = new FrameFiles(store, 0);
        for (int frame = 1; frame <= 6; frame++) {
            if (frame % 2 == 1) {
                files.next().close();
            }
            files.write(frame(frame));
        }
        files.next().close();
    }

    private static JournalRecord.Frame frame(long number) {
        return new JournalRecord.Frame(number,
                "{\"frame\":%d}".formatted(number).getBytes(StandardCharsets.UTF_8));
    }

    private List<Long> read(long from) throws IOException {
        List<Long> frames = new ArrayList<>();
        new FrameFiles(store, 0).read(from,
                record -> frames.add(((JournalRecord.Frame) record).frame()), problems::add);
        return frames;
    }
}
