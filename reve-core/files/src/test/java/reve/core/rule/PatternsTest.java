// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import static org.assertj.core.api.Assertions.assertThat;

import com.google.re2j.Pattern;
import com.google.re2j.PatternSyntaxException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.core.Seed;

import java.util.Random;

@Timeout(60)
class PatternsTest {
    private static final String[] PIECES = {
        "a",
        "b",
        "(",
        "(",
        ")",
        ")",
        "(?:",
        "(?i)",
        "(?P<n>",
        "[",
        "]",
        "[^",
        "[:",
        ":]",
        "[:alpha:]",
        "-",
        "^",
        "$",
        "|",
        "*",
        "+",
        "?",
        "{3}",
        "{2,}",
        "{0,4}",
        "{",
        "}",
        ",",
        "7",
        "\\",
        "\\Q",
        "\\E",
        "\\d",
        "\\pL",
        "\\p{Greek}",
        "\\x{41}",
        "\\x41",
        "\\]",
        "\\[",
        ".",
        "\ud83d\ude00"
    };

    @Test
    void sizeIsNeverEstimatedBelowWhatTheLibraryMakesOfAPattern() {
        long seed = Seed.of("patterns");
        var random = new Random(seed);
        int compiled = 0;
        for (int round = 0; round < 50_000; round++) {
            var text = new StringBuilder();
            for (int i = random.nextInt(14); i >= 0; i--) {
                text.append(PIECES[random.nextInt(PIECES.length)]);
            }
            String pattern = text.toString();
            if (Patterns.estimate(pattern) < 100_000 && !Patterns.foldsBeyondAscii(pattern)) {
                int size;
                try {
                    size = Pattern.compile(pattern).programSize();
                } catch (PatternSyntaxException broken) {
                    continue;
                }
                compiled++;
                assertThat(Patterns.estimate(pattern))
                        .as("seed %d: %s", seed, pattern)
                        .isGreaterThanOrEqualTo(size);
            }
        }
        assertThat(compiled).isGreaterThan(2_000);
    }

    @Test
    void aRepetitionAfterAnEmptyQuotationRepeatsWhatIsBeforeIt() {
        String pattern = "a{30}" + "\\Q\\E{5}".repeat(2);
        int size = Pattern.compile(pattern).programSize();
        assertThat(size).isGreaterThan(700);
        assertThat(Patterns.estimate(pattern)).isGreaterThanOrEqualTo(size);
    }

    @Test
    void setOfCharactersBeginsNoRange() {
        for (String set : new String[] {"\\p{Greek}", "\\pL", "\\d", "A-\\x{61}", "A-\\x61"}) {
            String pattern = "[" + set + "--[:][:a:]{20}:]";
            assertThat(Patterns.estimate(pattern))
                    .as(pattern)
                    .isGreaterThanOrEqualTo(Pattern.compile(pattern).programSize());
        }
    }

    @Test
    void estimateOfAnOrdinaryPatternIsClose() {
        assertThat(Patterns.estimate("^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$"))
                .isBetween(40L, 120L);
        assertThat(Patterns.estimate("(a{9}){9}")).isBetween(81L, 400L);
    }

    @Test
    void estimateOfAHugePatternIsHuge() {
        assertThat(Patterns.estimate("((a{1000}){1000}){1000}")).isGreaterThan(1_000_000_000L);
        assertThat(Patterns.estimate("(".repeat(90) + "a" + "){1000}".repeat(90)))
                .isEqualTo(Long.MAX_VALUE);
    }
}
