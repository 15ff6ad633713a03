// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.DisconnectedException;
import reve.agent.Join;
import reve.tests.Reve.Outcome;

import java.io.IOException;
import java.net.InetAddress;
import java.net.Socket;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** A server whose process may open few files, and clients that take as many as they can. */
@Tag("slow")
class DescriptorsIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();
    private static final int LIMIT = 256;

    @TempDir private Path folder;

    @Test
    void connectionsLeaveDescriptorsForTheStore() throws Exception {
        Path store = folder.resolve("my.db");
        var sockets = new ArrayList<Socket>();
        try (Server server =
                        serve(
                                "--store",
                                store.toString(),
                                "--store-every",
                                "0.2",
                                "--record",
                                folder.resolve("run.log").toString());
                AgentClient ada = join(server)) {
            for (int i = 0; i < LIMIT; i++) {
                sockets.add(connect(server));
            }
            for (int i = 0; i < 60; i++) {
                ada.perceive();
            }
            assertThat(sockets).anySatisfy(DescriptorsIT::isTurnedAway);
            assertThat(open(server)).isLessThanOrEqualTo(LIMIT - 48);
            long images = frames(store);
            while (frames(store) < images + 3) {
                ada.perceive();
            }
            server.process().toHandle().destroy();
            assertThat(server.events().untilEnd()).noneMatch(Server::isFault);
            assertThat(server.exitCode()).isZero();
        } finally {
            for (Socket socket : sockets) {
                socket.close();
            }
        }
        assertThat(Files.readString(folder.resolve("server.err")))
                .containsOnlyOnce("the process may open " + LIMIT + " files, enough for ")
                .contains("connections instead of 4096; raise the limit (ulimit -n) for more");
        Outcome check = Reve.runAsProcess("store", "check", store.toString());
        assertThat(check.code()).as(check.out()).isZero();
    }

    @Test
    void aFailureToAcceptIsReportedOnceInWords() throws Exception {
        var sockets = new ArrayList<Socket>();
        try (Server server = serve();
                AgentClient ada = join(server)) {
            limit(server, open(server) - 10);
            for (int i = 0; i < 40; i++) {
                sockets.add(connect(server));
            }
            for (int i = 0; i < 240; i++) {
                ada.perceive();
            }
            limit(server, LIMIT);
            for (Socket socket : sockets) {
                socket.close();
            }
            try (AgentClient bob = joinAfterThese(server)) {
                bob.perceive();
            }
        } finally {
            for (Socket socket : sockets) {
                socket.close();
            }
        }
        assertThat(Files.readString(folder.resolve("server.err")))
                .containsOnlyOnce(
                        "no connection can be accepted: Too many open files; see the limit of"
                                + " open files (ulimit -n)")
                .doesNotContain("Exception");
    }

    private Server serve(String... options) throws IOException {
        List<String> command =
                new ArrayList<>(
                        List.of("bash", "-c", "ulimit -n " + LIMIT + "; exec \"$@\"", "bash"));
        command.addAll(Reve.command("serve", WORLD, "--port", "0", "--json"));
        command.addAll(List.of(options));
        Path errors = folder.resolve("server.err");
        Process process = new ProcessBuilder(command).redirectError(errors.toFile()).start();
        return new Server(process, new Server.Events(process, errors));
    }

    private static AgentClient join(Server server) throws Exception {
        return join(server, "ada");
    }

    private static AgentClient join(Server server, String name) throws Exception {
        return Agents.join(Integer.parseInt(server.port()), Join.as(name));
    }

    /** Joins as soon as the server has noticed that the connections before this one are closed. */
    private static AgentClient joinAfterThese(Server server) throws Exception {
        for (int attempt = 1; ; attempt++) {
            try {
                return join(server, "bob");
            } catch (DisconnectedException early) {
                assertThat(early.code()).isEqualTo("too-many-connections");
                assertThat(attempt).as("attempts, 20 ms apart").isLessThan(500);
                Thread.sleep(20);
            }
        }
    }

    private static Socket connect(Server server) throws IOException {
        return new Socket(InetAddress.ofLiteral("127.0.0.1"), Integer.parseInt(server.port()));
    }

    private static void isTurnedAway(Socket socket) throws IOException {
        socket.setSoTimeout(100);
        byte[] answer;
        try {
            answer = socket.getInputStream().readNBytes(200);
        } catch (IOException open) { // reset, or still open
            throw new AssertionError("no reason was sent", open);
        }
        assertThat(new String(answer)).contains("too-many-connections");
    }

    /** Returns the number of descriptors that the server has open. */
    private static int open(Server server) throws IOException {
        try (var files = Files.list(Path.of("/proc/" + server.process().pid() + "/fd"))) {
            return (int) files.count();
        }
    }

    private long frames(Path store) throws IOException {
        String prefix = store.getFileName() + "-frames-";
        try (var files = Files.list(folder)) {
            return files.map(file -> file.getFileName().toString())
                    .filter(name -> name.startsWith(prefix))
                    .mapToLong(name -> Long.parseLong(name.substring(prefix.length())))
                    .max()
                    .orElse(0);
        }
    }

    private static void limit(Server server, int files) throws Exception {
        assertThat(
                        new ProcessBuilder(
                                        "prlimit",
                                        "--pid",
                                        String.valueOf(server.process().pid()),
                                        "--nofile=" + files + ":")
                                .start()
                                .waitFor())
                .isZero();
    }
}
