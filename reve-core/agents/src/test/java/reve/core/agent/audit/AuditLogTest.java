// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.TestClient;
import reve.core.agent.protocol.Encoding;

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
import java.util.concurrent.TimeUnit;
import java.util.stream.IntStream;
import java.util.stream.Stream;

/** The audit record, and failures of its disk. */
class AuditLogTest {
    private static final Path FULL = Path.of("/dev/full");

    @TempDir private Path folder;
    private Path file;
    private long nanos;
    private Instant now = Instant.parse("2030-01-01T00:00:00Z");

    @BeforeEach
    void name() {
        file = folder.resolve("audit.jsonl");
    }

    private AuditLog open(AuditPlan plan) throws IOException {
        return new AuditLog(plan, () -> now, () -> nanos);
    }

    private static boolean told(AuditLog audit, String text) {
        return audit.told(
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

        assertThatThrownBy(() -> new AuditLog(AuditPlan.of(nowhere)))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(
                        nowhere.toString(), "there is no folder " + nowhere.getParent());
        assertThatThrownBy(() -> new AuditLog(AuditPlan.of(folder)))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(folder.toString(), "Is a directory");
    }

    /** Opening a pipe for writing would wait for a reader. */
    @Test
    void aPipeIsRefused() throws Exception {
        assertThat(new ProcessBuilder("mkfifo", file.toString()).start().waitFor()).isZero();
        assertThatThrownBy(() -> new AuditLog(AuditPlan.of(file)))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(file.toString(), "it is a pipe, expected a file");
    }

    @Test
    void theRecordIsForItsOwnerAlone() throws Exception {
        open(AuditPlan.of(file)).close();
        assertThat(PosixFilePermissions.toString(Files.getPosixFilePermissions(file)))
                .isEqualTo("rw-------");
    }

    @Test
    void aFullFileIsRotatedAndTheOldestIsRemoved() throws Exception {
        try (AuditLog audit = open(new AuditPlan(file, 300, 3, false))) {
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
        Files.createDirectories(folder.resolve("audit.jsonl.1/full"));
        Files.createDirectories(folder.resolve("audit.jsonl.2/full"));
        try (AuditLog audit = open(new AuditPlan(file, 300, 2, false))) {
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

    @Test
    void aRecordThatACrashCutIsGoneOnWithOnALineOfItsOwn() throws Exception {
        Files.writeString(file, "{\"at\":\"2030");
        try (AuditLog audit = open(AuditPlan.of(file))) {
            told(audit, "next");
        }
        try (AuditLog audit = open(AuditPlan.of(file))) {
            told(audit, "last");
        }
        assertThat(Files.readAllLines(file)).hasSize(3).first().isEqualTo("{\"at\":\"2030");
    }

    @Test
    @Timeout(60)
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
            try (AuditLog audit = open(AuditPlan.of(file))) {
                told(audit, text);
            }
        }
        assertThat(told(file)).hasSize(3).endsWith("c");
    }

    @Test
    void aFullDiskIsReportedAndMessagesAreCountedWithoutTryingEach() throws Exception {
        try (AuditLog audit = open(AuditPlan.of(FULL))) {
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
        try (AuditLog audit = open(new AuditPlan(FULL, 1 << 20, 1, true))) {
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
        try (AuditLog audit = open(AuditPlan.of(link))) {
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
        try (AuditLog audit = open(AuditPlan.of(file))) {
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
        try (AuditLog first = open(AuditPlan.of(file))) {
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

    @Test
    void agentsGoOnWhereTheirRecordCannotBeWrittenAndTheOperatorIsTold() throws Exception {
        AgentServerConfig config = AgentRoom.CONFIG.withAudit(AuditPlan.of(FULL));
        try (var room = new AgentRoom(config);
                TestClient ada = room.join("ada")) {
            ada.say("{'t':'act','id':1,'item':'duck','action':'wind-up'}").sync();
            room.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
            room.stepUntil("it is reported", () -> !room.problems.isEmpty());
            assertThat(room.problems)
                    .containsExactly(
                            "audit: what clients are sent cannot be "
                                    + "recorded in /dev/full: No space left on device; "
                                    + "they are served without a record");
            assertThat(room.server.stats().unrecorded()).isPositive();
        }
    }

    @Test
    void whereARecordIsRequiredClientsAreDisconnectedAndRefusedWithTheReason() throws Exception {
        AgentServerConfig config =
                AgentRoom.CONFIG.withAudit(new AuditPlan(FULL, 1 << 20, 1, true));
        try (var room = new AgentRoom(config);
                TestClient ada = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada'}");
            room.stepUntil("it is there", () -> room.has("ada"));
            ada.expectBye("not-recorded");
            room.stepUntil("it has left", () -> !room.has("ada"));
            try (TestClient bob = room.connect()) {
                bob.say("{'t':'hello','protocol':1,'name':'bob'}").expectBye("not-recorded");
            }
            room.stepUntil("it is reported", () -> !room.problems.isEmpty());
            assertThat(room.problems.element()).contains("clients are disconnected until it can");
            assertThat(room.server.stats().unrecorded()).isZero();
        }
    }
}
