// SPDX-License-Identifier: Apache-2.0
import reve.core.agent.AgentServerConfig;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.SqliteStore;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;

import java.io.IOException;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Optional;

/**
 * Serves a world file on an ephemeral port for the tests in this folder. Prints the port, then
 * makes frames until its standard input ends.
 */
final class PondServer {

    public static void main(String[] arguments) throws Exception {
        Path file = Path.of(arguments[0]);
        System.setProperty(
                "reve.native.path",
                Path.of(System.getenv("REVE_ROOT"), "build", "native").toString());
        var plan =
                new WorldPlan(
                        WorldFile.load(file),
                        Long.MAX_VALUE,
                        new Persistence(
                                file.getParent(),
                                Optional.empty(),
                                Optional.empty(),
                                Optional.empty(),
                                10,
                                SqliteStore.Durability.NORMAL),
                        new Pictures(file.getParent(), List.of()));
        try (var server =
                new WorldServer(
                        List.of(plan),
                        Pacing.REAL_TIME,
                        patient(AgentServerConfig.onPort(0)),
                        Optional.empty(),
                        (event, fields) -> {})) {
            System.out.println(server.port());
            Thread.ofVirtual()
                    .start(
                            () -> {
                                while (readByte() >= 0) {
                                    // The loop ignores the input, because only its end has a
                                    // meaning.
                                }
                                server.stop();
                            });
            server.run();
        }
    }

    /** Returns settings for clients on a busy machine, which may be silent for minutes. */
    private static AgentServerConfig patient(AgentServerConfig usual) {
        AgentTimeouts t = usual.timeouts();
        Duration patience = Duration.ofMinutes(10);
        return new AgentServerConfig(
                usual.address(),
                usual.limits(),
                new AgentTimeouts(
                        patience,
                        patience,
                        patience,
                        t.flood(),
                        patience,
                        patience,
                        patience,
                        Optional.empty(),
                        t.linger()),
                usual.audit(),
                usual.security());
    }

    private static int readByte() {
        try {
            return System.in.read();
        } catch (IOException e) {
            return -1;
        }
    }
}
