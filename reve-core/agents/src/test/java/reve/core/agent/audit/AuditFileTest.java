// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.EnumSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.agent.TestClient;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Instant;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.TimeUnit;
import java.util.stream.IntStream;
import java.util.stream.Stream;

/** The file of the audit record, and failures of the disk with this file. */
class AuditFileTest {
    private static final Path FULL = Path.of("/dev/full");

    @TempDir private Path folder;
    private Path file;
    private long nanos;
    private Instant now = Instant.parse("2030-01-01T00:00:00Z");

    @BeforeEach
    void name() {
        file = folder.resolve("audit.jsonl");
    }

    private AuditFile open(AuditPlan plan) throws IOException {
        return new AuditFile(plan, () -> now, () -> nanos);
    }

    private boolean told(AuditFile audit, String text) {
        return audit.told(
                now,
                "world",
                "ada",
                Encoding.JSON,
                ByteBuffer.wrap(("{\"t\":\"" + text + "\"}\n").getBytes(StandardCharsets.UTF_8)));
    }

    private static List<String> told(Path file) throws IOException {
        return Files.readAllLines(file).stream()
                .map(line -> TestClient.json(line).at("/message/t").asString("gap"))
                .toList();
    }

    @Test
    void aPlaceThatCannotBeWrittenToIsRefusedByNameAndReason() {
        Path nowhere = folder.resolve("none/audit.jsonl");

        assertThatThrownBy(() -> open(AuditPlan.of(nowhere)))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(
                        nowhere.toString(), "there is no folder " + nowhere.getParent());
        assertThatThrownBy(() -> open(AuditPlan.of(folder)))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(folder.toString(), "Is a directory");
    }

    /** Opening a pipe for writing would wait for a reader. */
    @Test
    void aPipeIsRefused() throws Exception {
        assertThat(new ProcessBuilder("mkfifo", file.toString()).start().waitFor()).isZero();
        assertThatThrownBy(() -> open(AuditPlan.of(file)))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(file.toString(), "it is a pipe, expected a file");
    }

    @Test
    void theRecordIsForItsOwnerAlone() throws Exception {
        open(AuditPlan.of(file)).close();
        assertThat(PosixFilePermissions.toString(Files.getPosixFilePermissions(file)))
                .isEqualTo("rw-------");
    }

    /** Otherwise the record of each report of records would contain the report before it. */
    @ParameterizedTest
    @EnumSource
    void aReportOfRecordsIsRecordedWithTheHashOfItsRecords(Encoding encoding) throws Exception {
        var report =
                new ServerMessage.Report(
                        7,
                        3,
                        "audit",
                        Map.of("records", List.of(Map.of("message", "{\"t\":\"welcome\"}"))));
        try (AuditFile audit = open(AuditPlan.of(file))) {
            byte[] line = report.in(encoding);
            assertThat(audit.told(now, "world", "boss", encoding, ByteBuffer.wrap(line))).isTrue();
            assertThat(audit.recent().newest("world", Optional.empty(), true, 9))
                    .singleElement()
                    .satisfies(record -> assertThat(record.message()).doesNotContain("welcome"));
        }
        JsonNode message = TestClient.json(Files.readString(file)).get("message");
        assertThat(message.get("of").stringValue()).isEqualTo("audit");
        assertThat(message.at("/content/records").stringValue()).matches("sha256:[0-9a-f]{64}");
    }

    @Test
    void aFullFileIsRotatedAndTheOldestIsRemoved() throws Exception {
        try (AuditFile audit = open(new AuditPlan(file, 300, 3, false))) {
            for (int i = 0; i < 20; i++) {
                assertThat(told(audit, "m" + i)).isTrue();
            }
        }
        try (Stream<Path> files = Files.list(folder)) {
            assertThat(files.map(each -> each.getFileName().toString()))
                    .containsExactlyInAnyOrder(
                            "audit.jsonl", "audit.jsonl.1", "audit.jsonl.2", "audit.jsonl.3");
        }
        assertThat(told(file)).endsWith("m19");
        List<String> all =
                Stream.of(".3", ".2", ".1", "")
                        .flatMap(
                                older -> {
                                    Path each = folder.resolve("audit.jsonl" + older);
                                    try {
                                        assertThat(Files.size(each)).isLessThanOrEqualTo(300);
                                        return told(each).stream();
                                    } catch (IOException e) {
                                        throw new AssertionError(e);
                                    }
                                })
                        .toList();
        assertThat(all)
                .hasSizeBetween(8, 12)
                .isEqualTo(IntStream.range(20 - all.size(), 20).mapToObj(i -> "m" + i).toList());
    }

    @Test
    void aRecordThatCannotBeRotatedGrowsAndIsReported() throws Exception {
        try (AuditFile audit = open(new AuditPlan(file, 300, 2, false))) {
            Files.createDirectories(folder.resolve("audit.jsonl.1/full"));
            Files.createDirectories(folder.resolve("audit.jsonl.2/full"));
            for (int i = 0; i < 20; i++) {
                assertThat(told(audit, "m" + i)).isTrue();
            }
            assertThat(audit.problem())
                    .get()
                    .asString()
                    .contains(file.toString(), "cannot be rotated", "it grows beyond 300 bytes");
        }
        assertThat(told(file)).hasSize(20);
    }

    @ParameterizedTest
    @ValueSource(ints = {1, 2, 3})
    void aFileWithTheNameOfAnOlderRecordIsRefusedUnlessItIsOne(int number) throws Exception {
        Path older = Files.writeString(folder.resolve("audit.jsonl." + number), "notes\n");
        assertThatThrownBy(() -> open(new AuditPlan(file, 300, 3, false)))
                .isInstanceOf(IOException.class)
                .hasMessage(
                        "the audit record "
                                + file
                                + " could not be opened: "
                                + older
                                + " is there already and holds something else than an audit"
                                + " record; name another file, or move it away");
        assertThat(file).doesNotExist();
        Files.delete(older);
        Files.createDirectory(older);
        assertThatThrownBy(() -> open(new AuditPlan(file, 300, 3, false)))
                .hasMessageContaining(older + " is there already and is no file");
        if (number > 1) { // no number that is kept
            open(new AuditPlan(file, 300, number - 1, false)).close();
        }
    }

    @Test
    void rotationNeverReplacesAFileOfAnotherKind() throws Exception {
        Path older = folder.resolve("audit.jsonl.2");
        try (AuditFile audit = open(new AuditPlan(file, 300, 2, false))) {
            told(audit, "first");
            Files.writeString(older, "notes\n");
            for (int i = 0; i < 20; i++) {
                assertThat(told(audit, "m" + i)).isTrue();
            }
            assertThat(audit.problem())
                    .get()
                    .asString()
                    .contains(file + " cannot be rotated: " + older, "it grows beyond 300 bytes");
            Files.delete(older);
            for (int i = 0; i < 20; i++) {
                assertThat(told(audit, "n" + i)).isTrue();
            }
            assertThat(audit.problem()).isEmpty();
        }
        assertThat(told(older)).isNotEmpty();
    }

    @Test
    void rotationNeverReplacesTheRecordOfAnotherProcess() throws Exception {
        Path older = folder.resolve("audit.jsonl.1");
        try (AuditFile audit = open(new AuditPlan(file, 300, 1, false))) {
            Files.createFile(older);
            Process owner =
                    new ProcessBuilder(
                                    "python3",
                                    "-c",
                                    """
                                    import fcntl, sys
                                    file = open(sys.argv[1], "r+")
                                    fcntl.lockf(file, fcntl.LOCK_EX)
                                    print("locked", flush=True)
                                    sys.stdin.read()
                                    """,
                                    older.toString())
                            .start();
            try {
                assertThat(owner.inputReader().readLine()).isEqualTo("locked");
                assertThatThrownBy(
                                () ->
                                        open(
                                                new AuditPlan(
                                                        folder.resolve("audit.jsonl"),
                                                        300,
                                                        1,
                                                        false)))
                        .hasMessageContaining(older + " is in use by another process");
                for (int i = 0; i < 20; i++) {
                    assertThat(told(audit, "m" + i)).isTrue();
                }
                assertThat(audit.problem())
                        .get()
                        .asString()
                        .contains(older + " is in use by another process");
            } finally {
                owner.destroyForcibly().waitFor();
            }
        }
        assertThat(older).isEmptyFile();
        assertThat(told(file)).hasSize(20);
    }

    @Test
    void aNameThatLeavesNoRoomForTheNumbersOfOlderRecordsIsRefused() throws Exception {
        for (int length : List.of(254, 253, 300)) {
            Path named = folder.resolve("a".repeat(length));
            assertThatThrownBy(() -> open(new AuditPlan(named, 300, 10, false)))
                    .isInstanceOf(IOException.class)
                    .hasMessageContainingAll("its name is too long", "NAME.10");
        }
        open(new AuditPlan(folder.resolve("a".repeat(252)), 300, 10, false)).close();
    }

    @Test
    void aFileThatIsCutIsReportedAndGoesOn() throws Exception {
        try (AuditFile audit = open(AuditPlan.of(file))) {
            told(audit, "before");
            long size = Files.size(file);
            Files.write(file, new byte[0]);
            assertThat(audit.problem())
                    .get()
                    .asString()
                    .contains(file + " was cut to 0 of " + size + " bytes; a new one begins there");
            told(audit, "after");
            assertThat(audit.problem()).isEmpty();
        }
        assertThat(told(file)).containsExactly("after");
    }

    @Test
    void aRecordThatACrashCutIsGoneOnWithOnALineOfItsOwn() throws Exception {
        Files.writeString(file, "{\"at\":\"2030");
        try (AuditFile audit = open(AuditPlan.of(file))) {
            told(audit, "next");
        }
        try (AuditFile audit = open(AuditPlan.of(file))) {
            told(audit, "last");
        }
        assertThat(Files.readAllLines(file)).hasSize(3).first().isEqualTo("{\"at\":\"2030");
    }

    @Test
    @Timeout(600)
    void aTerabyteWithoutALineEndIsRefusedByItsBeginning() throws Exception {
        try (FileChannel sparse =
                FileChannel.open(file, StandardOpenOption.CREATE, StandardOpenOption.WRITE)) {
            sparse.write(ByteBuffer.wrap(new byte[1]), (1L << 40) - 1);
        }
        assertThatThrownBy(() -> open(AuditPlan.of(file)))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("holds something else than an audit record");
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "Dear diary",
                "{\"reveTokens\":1,\"tokens\":[]}",
                "-----BEGIN PRIVATE KEY-----\nMIIB\n-----END PRIVATE KEY-----\n",
                "\n",
                "{}\n",
                "{\"at\":\"2030-01-01T00:00:00Z\",\"world\":\"w\"}\nname: spring-orbit\n",
                "{\"at\":\"2030-01-01T00:00:00Z\",\"price\":3}\n"
            })
    void whatIsNoAuditRecordIsRefusedAndStaysAsItIs(String content) throws Exception {
        Files.writeString(file, content);
        assertThatThrownBy(() -> open(AuditPlan.of(file)))
                .isInstanceOf(IOException.class)
                .hasMessage(
                        "the audit record "
                                + file
                                + " could not be opened: it is there already and holds something"
                                + " else than an audit record; name another file, or move it away");
        assertThat(Files.readString(file)).isEqualTo(content);
    }

    @Test
    void aRecordIsGoneOnWithHoweverLongItsLastLineIs() throws Exception {
        Files.createFile(file);
        for (String text : List.of("a", "b".repeat(200_000), "c")) {
            try (AuditFile audit = open(AuditPlan.of(file))) {
                told(audit, text);
            }
        }
        assertThat(told(file)).hasSize(3).endsWith("c");
    }

    @Test
    void aFullDiskIsReportedAndMessagesAreCountedWithoutTryingEach() throws Exception {
        try (AuditFile audit = open(AuditPlan.of(FULL))) {
            assertThat(told(audit, "a")).isTrue();
            assertThat(told(audit, "b")).isTrue();
            assertThat(audit.problem())
                    .get()
                    .asString()
                    .contains("/dev/full", "No space left on device", "served without a record");
            assertThat(audit.unrecorded()).isEqualTo(2);
            assertThat(audit.isServing()).isTrue();
        }
    }

    @Test
    void withoutARecordNothingIsSentWhereOneIsRequired() throws Exception {
        try (AuditFile audit = open(new AuditPlan(FULL, 1 << 20, 1, true))) {
            assertThat(audit.isServing()).isTrue();
            assertThat(told(audit, "a")).isFalse();
            assertThat(audit.isServing()).isFalse();
            assertThat(audit.problem()).get().asString().contains("clients are disconnected");
            assertThat(audit.unrecorded()).as("nothing was sent").isZero();
        }
    }

    @Test
    void theFirstRecordAfterAGapSaysHowManyMessagesItLacks() throws Exception {
        Path link = Files.createSymbolicLink(folder.resolve("link"), FULL);
        try (AuditFile audit = open(AuditPlan.of(link))) {
            told(audit, "lost");
            Files.delete(link);
            told(audit, "lost too");
            assertThat(link).as("tried once a second").doesNotExist();
            nanos += TimeUnit.SECONDS.toNanos(1);
            now = now.plusSeconds(1);
            told(audit, "kept");
            assertThat(audit.problem()).isEmpty();
            assertThat(audit.solved())
                    .contains("2 messages since 2030-01-01T00:00:00Z have no record");
            assertThat(audit.unrecorded()).isEqualTo(2);
        }
        assertThat(told(link)).containsExactly("gap", "kept");
        JsonNode gap = TestClient.json(Files.readAllLines(link).getFirst());
        assertThat(gap)
                .isEqualTo(
                        TestClient.json(
                                "{'at':'2030-01-01T00:00:01Z','unrecorded':2,"
                                        + "'since':'2030-01-01T00:00:00Z'}"));
    }

    @Test
    void aFileThatIsMovedOrRemovedBeginsAnewAndIsReportedOnce() throws Exception {
        try (AuditFile audit = open(AuditPlan.of(file))) {
            told(audit, "before");
            assertThat(audit.problem()).isEmpty();
            Files.move(file, folder.resolve("moved"));
            assertThat(audit.problem())
                    .get()
                    .asString()
                    .contains(file + " was moved or removed; a new one begins there");
            told(audit, "after");
            assertThat(audit.problem()).isEmpty();
            Files.delete(file);
            assertThat(audit.problem()).isPresent();
            told(audit, "last");
        }
        assertThat(told(folder.resolve("moved"))).containsExactly("before");
        assertThat(told(file)).containsExactly("last");
    }

    @Test
    void aSecondServerIsRefusedOnTheSameFile() throws Exception {
        try (AuditFile first = open(AuditPlan.of(file))) {
            assertThatThrownBy(() -> open(AuditPlan.of(file)))
                    .hasMessage(
                            "the audit record "
                                    + file
                                    + " could not be opened: it is in use by another process; end"
                                    + " that one first, or name another file");
            assertThat(told(first, "kept")).isTrue();
        }
        open(AuditPlan.of(file)).close();
        assertThat(told(file)).containsExactly("kept");
    }
}
