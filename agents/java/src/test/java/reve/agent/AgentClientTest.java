// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.net.ConnectException;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.time.Duration;

/** A client that finds no server at its address. */
class AgentClientTest {

    private static final int BACKLOG = 1;

    @Test
    void whoWaitsLongerThanItsPatienceIsToldSo() throws IOException {
        try (var silent = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())) {
            Join ada = Join.as("ada").withPatience(Duration.ofMillis(50));
            assertThatExceptionOfType(AgentException.class)
                    .isThrownBy(
                            () ->
                                    AgentClient.connect("127.0.0.1", silent.getLocalPort(), ada)
                                            .close())
                    .withMessageContaining("silent for 0.05 s")
                    .extracting(AgentException::code)
                    .isEqualTo("no-answer");
        }
    }

    @Test
    void whereNobodyListensTheErrorNamesTheAddress() throws IOException {
        int free;
        try (var socket = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())) {
            free = socket.getLocalPort();
        }
        assertThatExceptionOfType(ConnectException.class)
                .isThrownBy(() -> AgentClient.connect("127.0.0.1", free, "ada").close())
                .withMessage(
                        "127.0.0.1:" + free + ": Connection refused; does a server run there?");
    }
}
