// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.io.ByteArrayOutputStream;
import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.Random;

class RopeTest {

    @Test
    void hasTheBytesThatWereWrittenFromAnyOffsetOn() {
        var random = new Random(1);
        for (int round = 0; round < 300; round++) {
            var flat = new ByteArrayOutputStream();
            Rope rope = random(random, 3, flat);
            byte[] expected = flat.toByteArray();
            assertThat(rope.size()).isEqualTo(expected.length);
            assertThat(rope.flat()).isEqualTo(expected);
            int offset = random.nextInt(expected.length + 1);
            var buffer = ByteBuffer.allocate(random.nextInt(2 * Rope.LEAST_BYTES));
            rope.get(offset, buffer);
            int count = Math.min(buffer.capacity(), expected.length - offset);
            assertThat(buffer.position()).isEqualTo(count);
            assertThat(Arrays.copyOf(buffer.array(), count))
                    .isEqualTo(Arrays.copyOfRange(expected, offset, offset + count));
        }
    }

    @Test
    void isWhatBytesHoldFromAPlaceOn() {
        var random = new Random(2);
        for (int round = 0; round < 300; round++) {
            var before = new ByteArrayOutputStream();
            var behind = new ByteArrayOutputStream();
            var bytes = new Bytes();
            write(random, 2, bytes, before);
            int start = bytes.size();
            bytes.putInt(0);
            behind.writeBytes(new byte[] {1, 2, 3, 4});
            write(random, 2, bytes, behind);
            bytes.setInt(start, 0x01020304);
            assertThat(bytes.rope(start).flat()).isEqualTo(behind.toByteArray());
            ByteBuffer view = bytes.view(start);
            byte[] seen = new byte[view.remaining()];
            view.get(seen);
            assertThat(seen).isEqualTo(behind.toByteArray());
            bytes.truncate(start);
            assertThat(bytes.toArray()).isEqualTo(before.toByteArray());
        }
    }

    @Test
    void holdsWhatIsLargeWithoutACopy() {
        var large = new Rope(new byte[100_000]);
        var bytes = new Bytes().put(1).put(large).put(2);
        assertThat(bytes.hasStrands()).isTrue();
        assertThat(bytes.rope(0).hold()).isLessThan(100_100);
        assertThat(new Bytes().put(3).put(large).rope(0).hold()).isLessThan(100);
    }

    private static Rope random(Random random, int depth, ByteArrayOutputStream flat) {
        var bytes = new Bytes();
        write(random, depth, bytes, flat);
        return bytes.rope(0);
    }

    private static void write(Random random, int depth, Bytes out, ByteArrayOutputStream flat) {
        for (int i = random.nextInt(5); i >= 0; i--) {
            if (depth > 0 && random.nextBoolean()) {
                out.put(random(random, depth - 1, flat));
            } else {
                byte[] own = new byte[random.nextInt(3) * random.nextInt(Rope.LEAST_BYTES)];
                random.nextBytes(own);
                out.put(own);
                flat.writeBytes(own);
            }
        }
    }
}
