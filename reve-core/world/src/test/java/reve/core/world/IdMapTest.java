// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;

import java.util.HashMap;
import java.util.Map;
import java.util.Random;

class IdMapTest {
    @Test
    void holdsTheSameAsAMapOfTheLibraryAfterEachOfManyChanges() {
        var random = new Random(Seed.of("id maps"));
        var map = new IdMap();
        Map<Long, Integer> expected = new HashMap<>();
        for (int change = 0; change < 20_000; change++) {
            long id = 1 + random.nextLong(change < 10_000 ? 1000 : 100) * (1L << random.nextInt(3));
            if (random.nextInt(3) == 0) {
                map.remove(id);
                expected.remove(id);
            } else {
                int value = random.nextInt();
                map.put(id, value);
                expected.put(id, value);
            }
            if (change == 15_000) {
                map.clear();
                expected.clear();
            }
            long other = 1 + random.nextLong(1000);
            assertThat(map.get(other, -1)).isEqualTo(expected.getOrDefault(other, -1));
        }
        for (long id = 1; id < 8000; id++) {
            assertThat(map.get(id, -1)).as("id %d", id).isEqualTo(expected.getOrDefault(id, -1));
        }
    }
}
