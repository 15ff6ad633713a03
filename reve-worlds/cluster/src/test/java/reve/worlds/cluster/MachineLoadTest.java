// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

/** The load of a machine. */
class MachineLoadTest {
    @Test
    void memoryThatTheDiskCacheCanFreeIsFree() {
        assertThat(
                        MachineLoad.memory(
                                "MemTotal:       16000000 kB\nMemFree:         1000000 kB\n"
                                        + "MemAvailable:   12000000 kB\nBuffers: 5 kB\n"))
                .isEqualTo(0.25);
        assertThat(MachineLoad.memory("")).as("unknown").isZero();
    }

    @Test
    void sharesOfThisMachineAreBetweenNoneAndAll() {
        MachineLoad load = new MachineLoad();
        assertThat(load.memory()).isGreaterThan(0).isLessThan(1);
        load.cpu();
        assertThat(load.cpu()).isBetween(0.0, 1.0);
    }
}
