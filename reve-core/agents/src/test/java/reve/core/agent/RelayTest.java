// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.protocol.Relay;
import reve.core.agent.protocol.Role;

import java.io.BufferedReader;
import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.Channels;
import java.nio.channels.SocketChannel;
import java.nio.charset.StandardCharsets;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;

/** Connections that another server of the process passes on. */
class RelayTest {

    private final BlockingQueue<String> news = new LinkedBlockingQueue<>();

    private final Relay relay =
            new Relay() {
                @Override
                public void welcomed(Role role, String world, String client) {
                    news.add(role + " " + world + " " + client);
                }

                @Override
                public void ended() {
                    news.add("ended");
                }
            };

    private SocketChannel connect(AgentRoom room, String hello) throws IOException {
        var client = new InetSocketAddress(InetAddress.ofLiteral("192.0.2.7"), 4711);
        SocketChannel channel = room.server.connect(client, relay);
        channel.write(ByteBuffer.wrap(hello.getBytes(StandardCharsets.UTF_8)));
        return channel;
    }

    private String news() throws InterruptedException {
        return String.valueOf(news.poll(300, TimeUnit.SECONDS));
    }

    private static BufferedReader lines(SocketChannel channel) {
        return new BufferedReader(Channels.newReader(channel, StandardCharsets.UTF_8));
    }

    @Test
    void theSessionStatesRoleWorldAndNameBeforeItsWelcome() throws Exception {
        try (AgentRoom room = new AgentRoom();
                SocketChannel channel =
                        connect(
                                room,
                                "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eye\","
                                        + "\"role\":\"observer\"}\n")) {
            BufferedReader lines = lines(channel);
            assertThat(lines.readLine()).startsWith("{\"t\":\"welcome\"");
            assertThat(news.poll()).isEqualTo("OBSERVER pond eye");
            channel.write(ByteBuffer.wrap("{\"t\":\"bye\"}\n".getBytes(StandardCharsets.UTF_8)));
            assertThat(news()).isEqualTo("ended");
        }
    }

    @Test
    void onlyLinesOfJsonAreRelayed() throws Exception {
        try (AgentRoom room = new AgentRoom();
                SocketChannel channel =
                        connect(
                                room,
                                "{\"t\":\"hello\",\"protocol\":1,\"name\":\"eye\","
                                        + "\"role\":\"observer\",\"encoding\":\"msgpack\"}\n")) {
            assertThat(lines(channel).readLine())
                    .startsWith("{\"t\":\"bye\",\"code\":\"encoding-unsupported\"");
            assertThat(news()).isEqualTo("ended");
        }
    }

    @Test
    void aForkComputesOnAThreadThatSharesNoProcessorWithRelays() throws Exception {
        try (AgentRoom room = new AgentRoom();
                TestClient control = room.connect()) {
            control.say("{'t':'hello','protocol':1,'name':'op','role':'control'}");
            control.expect("welcome");
            control.say("{'t':'fork','id':1,'frames':10}");
            room.stepUntil("the fork is answered", control::hasNews);
            assertThat(control.expect("result", "unsupported").get("reason").stringValue())
                    .endsWith("on a platform thread");
        }
    }
}
