package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThatThrownBy;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.time.Clock;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

class AuditLogTest {
    @TempDir
    private Path folder;

    @Test
    void aPlaceThatCannotBeWrittenToIsRefusedByNameAndReason() {
        Path nowhere = folder.resolve("none/audit.jsonl");

        assertThatThrownBy(() -> new AuditLog(nowhere, Clock.systemUTC()))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(nowhere.toString(),
                        "there is no folder " + nowhere.getParent());
        assertThatThrownBy(() -> new AuditLog(folder, Clock.systemUTC()))
                .isInstanceOf(IOException.class)
                .hasMessageContainingAll(folder.toString(), "Is a directory");
    }

    @Test
    void aFullDiskIsNamedWithItsFile() throws Exception {
        ByteBuffer line = ByteBuffer.wrap("{\"t\":\"bye\"}\n".getBytes(StandardCharsets.UTF_8));
        try (var audit = new AuditLog(Path.of("/dev/full"), Clock.systemUTC())) {
            assertThatThrownBy(() -> audit.told("world", "ada", Encoding.JSON, line))
                    .isInstanceOf(UncheckedIOException.class)
                    .hasMessageContainingAll("/dev/full", "No space left on device");
        }
    }

    @Test
    void whoCannotBeToldForWantOfARecordIsToldThat() throws Exception {
        AgentServerConfig config = AgentRoom.CONFIG.withAudit(Path.of("/dev/full"));
        try (var room = new AgentRoom(config); TestClient ada = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada'}");
            room.stepUntil("it is there", () -> room.has("ada"));
            ada.expectBye("failed");
            room.stepUntil("it has left", () -> !room.has("ada"));
        }
    }
}
