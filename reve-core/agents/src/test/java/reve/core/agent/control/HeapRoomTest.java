// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatCode;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;

import reve.core.world.ActionRefused;

/** The cases in which changes are refused because the heap is full. */
class HeapRoomTest {
    private static final long MIB = 1 << 20;

    private long used;
    private long unreachable;
    private int collections;
    private long time;

    private final HeapRoom room =
            new HeapRoom(
                    () -> used,
                    1000 * MIB,
                    () -> {
                        used -= unreachable;
                        unreachable = 0;
                        collections++;
                    },
                    () -> time);

    @Test
    void changesAreRefusedIfReachableObjectsFillTheHeap() {
        used = 749 * MIB;
        assertThatCode(room::require).doesNotThrowAnyException();
        assertThat(collections).isZero();
        used = 800 * MIB;
        for (int i = 0; i < 3; i++) {
            assertThatThrownBy(room::require)
                    .isInstanceOf(ActionRefused.class)
                    .hasMessageContaining("800 of 1000 MiB")
                    .hasMessageContaining("REVE_HEAP");
        }
        assertThat(collections).as("nothing has changed since the first").isEqualTo(1);
    }

    @Test
    void unreachableObjectsDoNotCount() {
        used = 900 * MIB;
        unreachable = 700 * MIB;
        assertThatCode(room::require).doesNotThrowAnyException();
        assertThat(collections).isEqualTo(1);
    }

    @Test
    void changesContinueWhenItemsWereRemoved() throws ActionRefused {
        used = 960 * MIB;
        assertThatThrownBy(room::require).isInstanceOf(ActionRefused.class);
        unreachable = 700 * MIB; // which only a garbage collection finds
        time = 9_000_000_000L;
        assertThatThrownBy(room::require).isInstanceOf(ActionRefused.class);
        assertThat(collections).isEqualTo(1);
        time = 11_000_000_000L;
        room.require();
        assertThat(collections).isEqualTo(2);
    }

    @Test
    void anEarlierCollectionSaysNothingAfterTheHeapWasSmaller() throws ActionRefused {
        used = 960 * MIB;
        assertThatThrownBy(room::require).isInstanceOf(ActionRefused.class);
        used = 300 * MIB;
        room.require();
        used = 790 * MIB;
        unreachable = 400 * MIB;
        room.require();
        assertThat(collections).isEqualTo(2);
    }

    @Test
    void theHeapOfThisProcessHasRoom() {
        assertThatCode(HeapRoom.OF_PROCESS::require).doesNotThrowAnyException();
    }
}
