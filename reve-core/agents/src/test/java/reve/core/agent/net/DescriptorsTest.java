// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

/** The number of file descriptors that are left for connections. */
class DescriptorsTest {
    private long open = 100;

    @Test
    void aReserveIsKeptFromConnections() {
        var descriptors = new Descriptors(() -> 200, () -> open);
        assertThat(descriptors.room()).isEqualTo(200 - 100 - Descriptors.RESERVE);
        descriptors.take();
        descriptors.take();
        descriptors.give();
        assertThat(descriptors.room()).isEqualTo(200 - 101 - Descriptors.RESERVE);
    }

    @Test
    void whatOtherPartsOfTheProcessOpenIsCounted() {
        var descriptors = new Descriptors(() -> 200, () -> open);
        open = 170;
        descriptors.count();
        assertThat(descriptors.room()).isNegative();
    }

    @Test
    void severalAreTakenAtOnceOrNone() {
        var descriptors = new Descriptors(() -> 200, () -> open);
        open = 200 - Descriptors.RESERVE - 4;
        descriptors.count();
        assertThat(descriptors.takeIfLeft(3)).isTrue();
        assertThat(descriptors.takeIfLeft(3)).isFalse();
        assertThat(descriptors.room()).isEqualTo(1);
    }

    @Test
    void aCountForWhichNoDescriptorIsLeftLeavesNoRoom() {
        var descriptors =
                new Descriptors(
                        () -> 200,
                        () -> {
                            if (open > 199) {
                                throw new InternalError("errno: 24");
                            }
                            return open;
                        });
        open = 200;
        descriptors.count();
        assertThat(descriptors.room()).isZero();
    }
}
