// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.TestClient;
import reve.core.agent.protocol.Encoding;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Optional;
import java.util.concurrent.TimeUnit;

/** The audit record beside a server, and disks that do not answer. */
class AuditLogTest {
    private static final Path FULL = Path.of("/dev/full");

    @TempDir private Path folder;

    /** Time that a message waits for a busy machine [ms]. */
    private static final long PATIENT = 300_000;

    /**
     * A terminal whose other end reads only when the test tells it to. A write to this terminal
     * waits like a write to a disk that does not answer.
     */
    private static final class StuckFile implements AutoCloseable {
        private final Process reader;
        private final BufferedReader said;
        final Path path;

        StuckFile() throws IOException {
            reader =
                    new ProcessBuilder(
                                    "python3",
                                    "-c",
                                    """
                                    import os, pty, sys, threading, tty
                                    ours, theirs = pty.openpty()
                                    tty.setraw(theirs)
                                    print(os.ttyname(theirs), flush=True)
                                    sys.stdin.readline()
                                    while True:
                                        sys.stdout.buffer.write(os.read(ours, 65536))
                                        sys.stdout.buffer.flush()
                                    """)
                            .start();
            said = reader.inputReader(StandardCharsets.UTF_8);
            path = Path.of(said.readLine());
        }

        void goOn() throws IOException {
            reader.outputWriter().write("\n");
            reader.outputWriter().flush();
        }

        String line() throws IOException {
            return said.readLine();
        }

        @Override
        public void close() {
            reader.destroyForcibly();
        }
    }

    private static boolean told(AuditLog audit, String text) {
        return audit.told(
                "world",
                "ada",
                Encoding.JSON,
                ByteBuffer.wrap(("{\"t\":\"" + text + "\"}\n").getBytes(StandardCharsets.UTF_8)));
    }

    private static void await(AuditLog audit, String text) throws InterruptedException {
        Optional<String> last = Optional.empty();
        for (long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(300);
                System.nanoTime() < end;
                Thread.sleep(20)) {
            last = audit.problem();
            if (last.orElse("").contains(text) && !text.isEmpty()
                    || text.isEmpty() && last.isEmpty()) {
                return;
            }
        }
        throw new AssertionError("expected " + text + ", found " + last);
    }

    @Test
    void closingWritesWhatWaits() throws Exception {
        Path file = folder.resolve("audit.jsonl");
        var audit = new AuditLog(AuditPlan.of(file), PATIENT);
        for (int i = 0; i < 1000; i++) {
            assertThat(told(audit, "m" + i)).isTrue();
        }
        audit.close();
        List<String> lines = Files.readAllLines(file);
        assertThat(lines).hasSize(1000);
        for (int i = 0; i < 1000; i++) {
            assertThat(TestClient.json(lines.get(i)).at("/message/t").asString())
                    .isEqualTo("m" + i);
        }
        assertThat(audit.unrecorded()).isZero();
    }

    @Test
    void aMessageThatCannotBeReadIsCountedAndTheNextOneIsRecorded() throws Exception {
        Path file = folder.resolve("audit.jsonl");
        try (var audit = new AuditLog(AuditPlan.of(file), PATIENT)) {
            ByteBuffer unreadable = ByteBuffer.wrap(new byte[] {0, 0, 0, 1, (byte) 0xc1});
            assertThat(audit.told("world", "ada", Encoding.MESSAGEPACK, unreadable)).isTrue();
            assertThat(told(audit, "next")).isTrue();
        }
        List<String> lines = Files.readAllLines(file);
        assertThat(lines).hasSize(2);
        assertThat(TestClient.json(lines.getFirst()).at("/unrecorded").asInt()).isEqualTo(1);
        assertThat(TestClient.json(lines.getLast()).at("/message/t").asString()).isEqualTo("next");
    }

    @Test
    @Timeout(600)
    void aDiskThatDoesNotAnswerDelaysNobodyAndTheGapIsRecorded() throws Exception {
        try (var stuck = new StuckFile();
                var audit = new AuditLog(AuditPlan.of(stuck.path))) {
            String text = "x".repeat(4000);
            long before = System.nanoTime();
            for (int i = 0; i < 100; i++) {
                assertThat(told(audit, text)).isTrue();
            }
            assertThat(System.nanoTime() - before)
                    .as("100 messages do not wait for a second each")
                    .isLessThan(TimeUnit.SECONDS.toNanos(60));
            await(audit, "the disk is too slow");
            assertThat(audit.problem().orElseThrow())
                    .contains(stuck.path.toString(), "they are served without a record");
            assertThat(told(audit, "lost")).isTrue();
            assertThat(told(audit, "lost")).isTrue();
            assertThat(audit.unrecorded()).isEqualTo(2);

            stuck.goOn();
            for (int i = 0; i < 100; i++) {
                assertThat(stuck.line()).contains(text);
            }
            assertThat(TestClient.json(stuck.line()).at("/unrecorded").asInt()).isEqualTo(2);
            await(audit, "");
            assertThat(audit.solved()).contains("2 messages since");
            assertThat(told(audit, "kept")).isTrue();
            assertThat(stuck.line()).contains("kept");
            assertThat(audit.unrecorded()).isEqualTo(2);
        }
    }

    @Test
    @Timeout(600)
    void whereARecordIsRequiredADiskThatDoesNotAnswerDelaysOneMessage() throws Exception {
        try (var stuck = new StuckFile();
                var audit = new AuditLog(new AuditPlan(stuck.path, 1 << 20, 1, true))) {
            String text = "x".repeat(4000);
            while (told(audit, text)) {
                assertThat(audit.isServing()).isTrue();
            }
            assertThat(audit.isServing()).isFalse();
            long before = System.nanoTime();
            for (int i = 0; i < 100; i++) {
                assertThat(told(audit, text)).isFalse();
            }
            assertThat(System.nanoTime() - before)
                    .as("100 messages do not wait for a second each")
                    .isLessThan(TimeUnit.SECONDS.toNanos(60));
            await(audit, "clients are disconnected");

            stuck.goOn();
            await(audit, "");
            while (!audit.isServing()) {
                audit.problem();
                Thread.sleep(20);
            }
            assertThat(told(audit, "kept")).isTrue();
            assertThat(audit.unrecorded()).as("nothing was sent").isZero();
        }
    }

    @Test
    @Timeout(600)
    void closingGivesUpADiskThatDoesNotAnswerAndCountsWhatIsLost() throws Exception {
        try (var stuck = new StuckFile()) {
            var audit = new AuditLog(AuditPlan.of(stuck.path));
            for (int i = 0; i < 100; i++) {
                told(audit, "x".repeat(4000));
            }
            await(audit, "the disk is too slow");
            audit.close();
            assertThat(audit.unrecorded()).isBetween(1L, 100L);
        }
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
