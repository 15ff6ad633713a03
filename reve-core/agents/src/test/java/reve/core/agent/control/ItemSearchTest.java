// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.world.ClassHierarchy;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;

import java.lang.management.ManagementFactory;
import java.lang.management.ThreadMXBean;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.stream.Stream;

/** A search compared with one that tries all places. */
class ItemSearchTest {
    private static final String LETTERS = "aAbBäÄßıI ";

    private static ItemSymbols item(String name, Map<String, Object> symbols) {
        ItemDefinition.Builder item = ItemDefinition.named(name);
        symbols.forEach(item::symbol);
        return new ItemSymbols(new ItemId(1), item.build(), ClassHierarchy.NONE);
    }

    private static String text(Random random, int most) {
        StringBuilder text = new StringBuilder();
        for (int i = random.nextInt(most + 1); i > 0; i--) {
            text.append(LETTERS.charAt(random.nextInt(LETTERS.length())));
        }
        return text.toString();
    }

    private static boolean contains(String text, String wanted) {
        for (int i = 0; i <= text.length() - wanted.length(); i++) {
            if (text.regionMatches(true, i, wanted, 0, wanted.length())) {
                return true;
            }
        }
        return false;
    }

    @Test
    void findsWhatIsInATextInLettersOfAnyCase() {
        Random random = new Random(1);
        int found = 0;
        for (int i = 0; i < 20_000; i++) {
            String value = text(random, 12);
            String wanted = text(random, 4);
            ItemSymbols item = item("z", Map.of("q", value));
            var search = new ItemSearch(List.of(item), wanted);
            assertThat(search.step()).isFalse();
            boolean expected =
                    Stream.of("z", "q", value, "class", item.kind())
                            .anyMatch(text -> contains(text, wanted));
            assertThat(search.result().get("count"))
                    .as("'%s' in '%s'", wanted, value)
                    .isEqualTo(expected ? 1 : 0);
            found += expected ? 1 : 0;
        }
        assertThat(found).isBetween(1_000, 19_000);
    }

    /** All places of these texts begin like the wanted one. */
    @Test
    void itsTimeIsThatOfTheTextsLength() {
        List<ItemSymbols> items =
                List.of(item("z", Map.of("q", Collections.nCopies(64, "a".repeat(4096)))));
        // A search that begins again at each place takes 1,000 times as long.
        assertThat((double) nanoseconds(items, "a".repeat(999) + "b"))
                .as("ratio to a text that is nowhere similar")
                .isLessThan(30.0 * nanoseconds(items, "b".repeat(1000)));
    }

    /** Returns the least processor time of five searches that find nothing. */
    private static long nanoseconds(List<ItemSymbols> items, String wanted) {
        ThreadMXBean threads = ManagementFactory.getThreadMXBean();
        long least = Long.MAX_VALUE;
        for (int i = 0; i < 5; i++) {
            var search = new ItemSearch(items, wanted);
            long start = threads.getCurrentThreadCpuTime();
            search.step();
            least = Math.min(least, threads.getCurrentThreadCpuTime() - start);
            assertThat(search.result().get("count")).isEqualTo(0);
        }
        return least;
    }

    /** A search pauses after a number of characters, and not of items. */
    @Test
    void itPausesBetweenItemsWithLongTexts() {
        ItemSymbols large = item("z", Map.of("q", Collections.nCopies(17, "a".repeat(4096))));
        var search = new ItemSearch(Collections.nCopies(3, large), "b");
        assertThat(search.step()).isTrue();
        assertThat(search.step()).isTrue();
        assertThat(search.step()).isFalse();
    }
}
