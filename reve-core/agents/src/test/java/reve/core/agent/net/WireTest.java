// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.StandardSocketOptions;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;

class WireTest {

    @Test
    void whoIsSentMuchAtATimeGetsALargerSendBufferThanASegmentOfLoopbackHas() throws Exception {
        try (var listening =
                        ServerSocketChannel.open()
                                .bind(new InetSocketAddress(InetAddress.getLoopbackAddress(), 0));
                SocketChannel client = SocketChannel.open(listening.getLocalAddress());
                Wire wire = Wire.of(client, (InetSocketAddress) client.getRemoteAddress())) {
            wire.expectMuch();
            assertThat(client.getOption(StandardSocketOptions.SO_SNDBUF)).isGreaterThan(128 * 1024);
        }
    }
}
