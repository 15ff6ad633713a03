// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import java.util.List;
import java.util.Optional;

class NodeSettingsTest {
    private static final NodeAddress HERE = new NodeAddress("127.0.0.1", 0);
    private static final String STORE = "postgresql://reve@127.0.0.1/worlds?sslmode=disable";

    @Test
    void addressesAreNamesOrNumbersWithAPort() throws Exception {
        NodeAddress named = NodeAddress.parse("db-1.example:65535");
        assertThat(named).isEqualTo(new NodeAddress("db-1.example", 65_535));
        assertThat(NodeAddress.parse(named.toString())).isEqualTo(named);
        assertThat(NodeAddress.parse("127.0.0.1:0").isLoopback()).isTrue();
        assertThat(NodeAddress.parse("127.9.9.9:1").isLoopback()).isTrue();
        assertThat(NodeAddress.parse("0.0.0.0:1").isLoopback()).isFalse();
        assertThat(NodeAddress.parse("10.0.0.1:1").isLoopback()).isFalse();
    }

    @ParameterizedTest
    @ValueSource(strings = {"", "host", "host:", ":1", "host:65536", "host:-1", "[::1]:1", "a b:1"})
    void otherAddressesAreRefused(String text) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> NodeAddress.parse(text))
                .withMessageContainingAll("'" + text + "'", "expected HOST:PORT");
    }

    @Test
    void aClusterHasANameAndADatabase() {
        assertThat(
                        new NodeSettings(
                                        "lab-2",
                                        HERE,
                                        List.of(),
                                        STORE,
                                        Optional.empty(),
                                        Optional.empty(),
                                        false)
                                .database()
                                .tls())
                .containsEntry("sslmode", "disable");
        for (String name : List.of("", "-lab", "my lab", "l".repeat(65))) {
            assertThatIllegalArgumentException()
                    .isThrownBy(
                            () ->
                                    new NodeSettings(
                                            name,
                                            HERE,
                                            List.of(),
                                            STORE,
                                            Optional.empty(),
                                            Optional.empty(),
                                            false))
                    .withMessageContaining("the cluster is called '" + name + "'");
        }
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                new NodeSettings(
                                        "lab",
                                        HERE,
                                        List.of(),
                                        "my.db",
                                        Optional.empty(),
                                        Optional.empty(),
                                        false))
                .withMessageContaining("the store of a cluster is my.db");
        NodeAddress open = new NodeAddress("10.0.0.1", 2551);
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                new NodeSettings(
                                        "lab",
                                        open,
                                        List.of(),
                                        STORE,
                                        Optional.empty(),
                                        Optional.empty(),
                                        false))
                .withMessageContaining("other machines reach 10.0.0.1:2551, so nodes take TLS");
    }

    @Test
    void theMessageThatWakesAWorldHasNoContent() {
        var serializer = new WakeSerializer();
        byte[] bytes = serializer.toBinary(WorldCommand.Wake.INSTANCE);
        assertThat(serializer.fromBinaryJava(bytes, null)).isEqualTo(WorldCommand.Wake.INSTANCE);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> serializer.toBinary(new WorldCommand.Stop()))
                .withMessageContaining("cannot be sent to another");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> serializer.fromBinaryJava(new byte[1], null))
                .withMessageContaining("1 bytes");
    }
}
