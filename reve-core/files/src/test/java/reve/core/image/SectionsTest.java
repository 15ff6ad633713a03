// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;

import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Random;

class SectionsTest {

    private static final long SEED = 20261121;

    @Test
    void sectionsComeBackInTheirOrder() {
        Map<String, byte[]> sections = sections();
        Map<String, byte[]> back = Sections.read(Sections.write(sections));
        assertThat(back.keySet()).containsExactlyElementsOf(sections.keySet());
        back.forEach((name, bytes) -> assertThat(bytes).isEqualTo(sections.get(name)));
    }

    @Test
    void everyFlippedBitIsFound() {
        byte[] whole = Sections.write(sections());
        for (int bit = 0; bit < 8 * whole.length; bit++) {
            byte[] damaged = whole.clone();
            damaged[bit / 8] ^= (byte) (1 << bit % 8);
            assertThatExceptionOfType(CorruptException.class)
                    .as("bit %d", bit)
                    .isThrownBy(() -> Sections.read(damaged));
        }
    }

    @Test
    void everyCutAndEveryAdditionIsFound() {
        byte[] whole = Sections.write(sections());
        for (int length = 0; length < whole.length; length++) {
            byte[] cut = Arrays.copyOf(whole, length);
            assertThatExceptionOfType(CorruptException.class)
                    .as("%d bytes", length)
                    .isThrownBy(() -> Sections.read(cut));
        }
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> Sections.read(Arrays.copyOf(whole, whole.length + 1)));
    }

    @Test
    void anotherVersionIsNamed() {
        byte[] newer = Sections.write(sections());
        newer[8] = 99;
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> Sections.read(newer))
                .withMessageContaining("version 99")
                .withMessageContaining("reads 1");
    }

    private static Map<String, byte[]> sections() {
        Map<String, byte[]> sections = new LinkedHashMap<>();
        Random random = new Random(SEED);
        for (String name : new String[] {"header", "empty", "body.mass"}) {
            byte[] bytes = new byte[name.equals("empty") ? 0 : 100];
            random.nextBytes(bytes);
            sections.put(name, bytes);
        }
        return sections;
    }
}
