// SPDX-License-Identifier: Apache-2.0
import reve.core.agent.AgentServerConfig;
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
                        AgentServerConfig.onPort(0).withDeadline(Duration.ofSeconds(10)),
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

    private static int readByte() {
        try {
            return System.in.read();
        } catch (IOException e) {
            return -1;
        }
    }
}
