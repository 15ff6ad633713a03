// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import tools.jackson.databind.ObjectMapper;

import java.io.IOException;
import java.io.OutputStream;
import java.net.ConnectException;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.List;

/** Addresses at which there is no server of worlds, or a faulty server. */
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

    private static final String WELCOME =
            """
            {"t":"welcome","protocol":1,"role":"agent","agent":"ada","body":"duck","world":"pond",\
            "frame":0,"rate":60,"encoding":"msgpack","limits":{"lineBytes":1,\
            "messagesPerSecond":1,"actsInFlight":1,"idleSeconds":1,"graceSeconds":1}}""";

    private static Talk moved(ServerSocket to) {
        return client ->
                client.write(
                        ("{\"t\":\"bye\",\"code\":\"moved\",\"message\":\"it is elsewhere\",\"address\":"
                                        + "\"127.0.0.1:"
                                        + to.getLocalPort()
                                        + "\"}\n")
                                .getBytes(StandardCharsets.UTF_8));
    }

    @Test
    @Timeout(600)
    void aClientFollowsAServerThatNamesAnother() throws IOException {
        Talk welcomes =
                client -> {
                    client.write((WELCOME + "\n").getBytes(StandardCharsets.UTF_8));
                    Thread.sleep(Duration.ofDays(1));
                };
        try (ServerSocket second = serve(welcomes);
                ServerSocket first = serve(moved(second));
                AgentClient ada =
                        AgentClient.connect(
                                "127.0.0.1",
                                first.getLocalPort(),
                                Join.as("ada").withPatience(Duration.ofSeconds(30)))) {
            assertThat(ada.welcome().world()).isEqualTo("pond");
        }
    }

    @Test
    @Timeout(600)
    void aClientDoesNotFollowForEver() throws IOException {
        try (var circle = new ServerSocket(0, 8, InetAddress.getLoopbackAddress())) {
            Thread.ofVirtual()
                    .start(
                            () -> {
                                while (true) {
                                    try (Socket client = circle.accept()) {
                                        client.getInputStream().read(new byte[65_536]);
                                        moved(circle).with(client.getOutputStream());
                                    } catch (Exception closed) {
                                        return;
                                    }
                                }
                            });
            assertRefused(circle, Join.as("ada"), "moved", "it is elsewhere");
        }
    }

    /** The next server ends while the client resumes there; the client asks the first one again. */
    @Test
    @Timeout(600)
    void aSessionContinuesAlthoughTheNextServerEnds() throws IOException {
        String session =
                WELCOME.replace(
                        "\"frame\":0",
                        "\"frame\":0,\"session\":{\"token\":\""
                                + "0".repeat(32)
                                + "\",\"graceSeconds\":60}");
        byte[] welcome = (session + "\n").getBytes(StandardCharsets.UTF_8);
        try (var second = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress());
                var first = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())) {
            answer(
                    first,
                    call -> {
                        if (call.number() == 1) {
                            call.write(welcome);
                            call.read(); // the ping
                        }
                        moved(second).with(call.client().getOutputStream());
                    });
            answer(
                    second,
                    call -> {
                        if (call.number() == 1) {
                            call.write(
                                    "{\"t\":\"bye\",\"code\":\"closing\",\"message\":\"ends\"}\n"
                                            .getBytes(StandardCharsets.UTF_8));
                            return;
                        }
                        call.write(welcome);
                        call.read(); // the ping again
                        call.write("{\"t\":\"pong\",\"id\":1}\n".getBytes(StandardCharsets.UTF_8));
                        call.read(); // the bye
                    });
            try (AgentClient ada =
                    AgentClient.connect(
                            "127.0.0.1",
                            first.getLocalPort(),
                            Join.as("ada").withGrace(Duration.ofSeconds(60)))) {
                ada.ping();
            }
        }
    }

    /**
     * The only server that the client has asked is lost; a silent one and a third one are known.
     */
    @Test
    @Timeout(600)
    @SuppressWarnings("try") // closes the first server early
    void aSessionContinuesOnAServerThatTheWelcomeNames() throws IOException {
        try (var first = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress());
                var silent = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress());
                var third = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())) {
            byte[] welcome =
                    (WELCOME.replace(
                                            "\"frame\":0",
                                            "\"frame\":0,\"session\":{\"token\":\""
                                                    + "0".repeat(32)
                                                    + "\",\"graceSeconds\":60,\"servers\":"
                                                    + "[\"127.0.0.1:"
                                                    + silent.getLocalPort()
                                                    + "\",\"127.0.0.1:"
                                                    + third.getLocalPort()
                                                    + "\"]}")
                                    + "\n")
                            .getBytes(StandardCharsets.UTF_8);
            answer(
                    first,
                    call -> {
                        call.write(welcome);
                        call.read(); // the ping
                        first.close();
                    });
            answer(
                    third,
                    call -> {
                        call.write(welcome);
                        call.read(); // the ping again
                        call.write("{\"t\":\"pong\",\"id\":1}\n".getBytes(StandardCharsets.UTF_8));
                        call.read(); // the bye
                    });
            try (AgentClient ada =
                    AgentClient.connect(
                            "127.0.0.1",
                            first.getLocalPort(),
                            Join.as("ada")
                                    .withGrace(Duration.ofSeconds(60))
                                    .withPatience(Duration.ofSeconds(30)))) {
                ada.ping();
            }
        }
    }

    private record Call(int number, Socket client) {
        void write(byte[] bytes) throws IOException {
            client.getOutputStream().write(bytes);
        }

        void read() throws IOException {
            client.getInputStream().read(new byte[65_536]);
        }
    }

    private interface Answer {
        void to(Call call) throws Exception;
    }

    /** Answers one connection after another, after the client's hello. */
    private static void answer(ServerSocket server, Answer answer) {
        Thread.ofVirtual()
                .start(
                        () -> {
                            for (int i = 1; ; i++) {
                                try (Socket client = server.accept()) {
                                    Call call = new Call(i, client);
                                    call.read();
                                    answer.to(call);
                                } catch (Exception closed) {
                                    if (server.isClosed()) {
                                        return;
                                    }
                                }
                            }
                        });
    }

    @Test
    @Timeout(600)
    void aSessionContinuesOnTheServerToWhichItsWorldMoves() throws IOException {
        String session =
                WELCOME.replace(
                        "\"frame\":0",
                        "\"frame\":0,\"session\":{\"token\":\""
                                + "0".repeat(32)
                                + "\",\"graceSeconds\":60}");
        byte[] welcome = (session + "\n").getBytes(StandardCharsets.UTF_8);
        try (var second = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress());
                var first = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress())) {
            Thread.ofVirtual()
                    .start(
                            () -> {
                                try (Socket client = first.accept()) {
                                    client.getInputStream().read(new byte[65_536]);
                                    client.getOutputStream().write(welcome);
                                    client.getInputStream().read(new byte[65_536]); // the ping
                                    moved(second).with(client.getOutputStream());
                                } catch (Exception e) {
                                    // The client has left, or the test ends.
                                }
                            });
            Thread.ofVirtual()
                    .start(
                            () -> {
                                try (Socket client = second.accept()) {
                                    client.getInputStream().read(new byte[65_536]);
                                    client.getOutputStream().write(welcome);
                                    client.getInputStream().read(new byte[65_536]); // again
                                    client.getOutputStream()
                                            .write(
                                                    "{\"t\":\"pong\",\"id\":1}\n"
                                                            .getBytes(StandardCharsets.UTF_8));
                                    client.getInputStream().read(new byte[65_536]); // the bye
                                } catch (Exception e) {
                                    // The client has left, or the test ends.
                                }
                            });
            Join join =
                    Join.as("ada")
                            .withGrace(Duration.ofSeconds(60))
                            .withPatience(Duration.ofSeconds(30));
            try (AgentClient ada = AgentClient.connect("127.0.0.1", first.getLocalPort(), join)) {
                ada.ping();
            }
        }
    }

    /** The behaviour of a faulty server after it has read the hello. */
    private interface Talk {
        void with(OutputStream client) throws Exception;
    }

    /** Starts a server for one client. */
    private static ServerSocket serve(Talk talk) throws IOException {
        var server = new ServerSocket(0, BACKLOG, InetAddress.getLoopbackAddress());
        Thread.ofVirtual()
                .start(
                        () -> {
                            try (Socket client = server.accept()) {
                                client.getInputStream().read(new byte[65_536]);
                                talk.with(client.getOutputStream());
                            } catch (Exception e) {
                                // The client has left, or the test ends.
                            }
                        });
        return server;
    }

    private static void assertRefused(ServerSocket server, Join join, String code, String message) {
        assertThatExceptionOfType(AgentException.class)
                .isThrownBy(
                        () -> {
                            try (AgentClient ada =
                                    AgentClient.connect("127.0.0.1", server.getLocalPort(), join)) {
                                ada.perceive();
                            }
                        })
                .withMessageContaining(message)
                .extracting(AgentException::code)
                .isEqualTo(code);
    }

    @Test
    @Timeout(600)
    void thePatienceLimitsJoiningWhateverTheServerSends() throws IOException {
        for (String drip : List.of("{\"t\":\"ping\"}\n", " ")) {
            Talk talk =
                    client -> {
                        while (true) {
                            client.write(drip.getBytes(StandardCharsets.UTF_8));
                            Thread.sleep(20);
                        }
                    };
            try (ServerSocket server = serve(talk)) {
                Join ada = Join.as("ada").withPatience(Duration.ofMillis(300));
                assertRefused(server, ada, "no-answer", "silent for 0.3 s");
            }
        }
    }

    @Test
    @Timeout(600)
    void bytesWithoutEndBeforeTheWelcomeAreRefused() throws IOException {
        Talk talk =
                client -> {
                    while (true) {
                        client.write(new byte[65_536]);
                    }
                };
        try (ServerSocket server = serve(talk)) {
            assertRefused(server, Join.as("ada"), "protocol", "expected at most 1048576 bytes");
        }
    }

    @Test
    @Timeout(600)
    void aMessageOfMoreThan16MebibytesIsReadInMessagePack() throws Exception {
        var event = new ObjectMapper().createObjectNode();
        event.put("t", "event").put("frame", 1).put("type", "said");
        event.putObject("fields").put("text", "x".repeat(17 << 20));
        byte[] packed = Packed.write(event);
        assertThat(packed[0]).as("the length needs its first byte").isNotZero();
        Talk talk =
                client -> {
                    client.write((WELCOME + "\n").getBytes(StandardCharsets.UTF_8));
                    client.write(packed);
                    Thread.sleep(Duration.ofMinutes(1));
                };
        try (ServerSocket server = serve(talk)) {
            Join join = Join.as("ada").withEncoding(Encoding.MESSAGEPACK);
            try (AgentClient ada = AgentClient.connect("127.0.0.1", server.getLocalPort(), join)) {
                List<WorldEvent> heard = List.of();
                while (heard.isEmpty()) {
                    Thread.sleep(20);
                    heard = ada.events();
                }
                assertThat(heard).singleElement().extracting(WorldEvent::type).isEqualTo("said");
            }
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
