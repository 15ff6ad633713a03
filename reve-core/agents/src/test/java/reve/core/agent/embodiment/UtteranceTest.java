// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.agent.embodiment.Utterance.Arrived;
import reve.core.world.ItemId;
import reve.core.world.Voice;

import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** What arrives of a text. The frames are the seeds of the statistics, so these never change. */
class UtteranceTest {

    private static final int FRAMES = 20_000;
    private static final double FADING = 8;
    private static final double FAR = 1e6;
    private static final ItemId ADA = new ItemId(7);
    private static final ItemId BOB = new ItemId(8);
    private static final ItemId CAT = new ItemId(9);

    private static Utterance said(long frame, String text) {
        return new Utterance(
                "pond", frame, ADA, new double[] {0, 0, 0}, new Voice(FAR, FADING), text);
    }

    private static boolean arrives(long frame, ItemId hearer, double distance) {
        return said(frame, "come").at(hearer, FAR, distance).isPresent();
    }

    /** Asserts that a count has the binomial distribution's mean, within four deviations. */
    private static void requireMean(String what, long count, long trials, double probability) {
        double mean = trials * probability;
        double deviation = Math.sqrt(mean * (1 - probability));
        assertThat((double) count)
                .as("%s: %d of %d, expected %.1f", what, count, trials, mean)
                .isBetween(mean - 4 * deviation, mean + 4 * deviation);
    }

    @ParameterizedTest
    @ValueSource(doubles = {0.5, 2, 4, 6.6604, 8, 12, 16})
    void aWordArrivesAsOftenAsTheLawSays(double distance) {
        long arrived = 0;
        for (int frame = 0; frame < FRAMES; frame++) {
            arrived += arrives(frame, BOB, distance) ? 1 : 0;
        }
        double law = Math.exp(-Math.pow(distance / FADING, 2));
        requireMean(distance + " m", arrived, FRAMES, law);
    }

    /** Neighbouring frames, hearers, and words of one text, at the distance of one half. */
    @Test
    void theLossesAreIndependent() {
        double half = FADING * Math.sqrt(Math.log(2));
        long inBothFrames = 0;
        long byBothHearers = 0;
        long bothWords = 0;
        long everyWordOfFour = 0;
        for (int frame = 0; frame < FRAMES; frame++) {
            boolean bob = arrives(frame, BOB, half);
            inBothFrames += bob && arrives(frame + 1, BOB, half) ? 1 : 0;
            byBothHearers += bob && arrives(frame, CAT, half) ? 1 : 0;
            bothWords += lost(said(frame, "come here").at(BOB, FAR, half)) == 0 ? 1 : 0;
            everyWordOfFour += lost(said(frame, "a b a b").at(BOB, FAR, half)) == 0 ? 1 : 0;
        }
        requireMean("two frames", inBothFrames, FRAMES, 0.25);
        requireMean("two hearers", byBothHearers, FRAMES, 0.25);
        requireMean("two words", bothWords, FRAMES, 0.25);
        requireMean("four words", everyWordOfFour, FRAMES, 0.0625);
    }

    private static int lost(Optional<Arrived> arrived) {
        return arrived.map(Arrived::lost).orElse(Integer.MAX_VALUE);
    }

    @Test
    void theSameUtteranceArrivesTheSameAndAnotherOneOtherwise() {
        String text = "one two three four five six seven eight nine ten";
        Arrived once = said(5, text).at(BOB, FAR, 6).orElseThrow();
        assertThat(said(5, text).at(BOB, FAR, 6)).contains(once);
        var others = new HashSet<Arrived>();
        others.add(once);
        others.add(said(6, text).at(BOB, FAR, 6).orElseThrow());
        others.add(said(5, text).at(CAT, FAR, 6).orElseThrow());
        others.add(
                new Utterance("lake", 5, ADA, new double[3], new Voice(FAR, FADING), text)
                        .at(BOB, FAR, 6)
                        .orElseThrow());
        others.add(
                new Utterance("pond", 5, CAT, new double[3], new Voice(FAR, FADING), text)
                        .at(BOB, FAR, 6)
                        .orElseThrow());
        assertThat(others).as("world, frame, speaker and hearer matter").hasSize(5);
    }

    @Test
    void aLostWordIsReplacedAndBlanksStay() {
        String text = "  the\told \n bridge ";
        int withLosses = 0;
        for (int frame = 0; frame < 200; frame++) {
            Optional<Arrived> arrived = said(frame, text).at(BOB, FAR, 6);
            if (arrived.isEmpty()) {
                continue;
            }
            int lost = arrived.get().lost();
            assertThat(arrived.get().text()).matches("  (the|…)\t(old|…) \n (bridge|…) ");
            assertThat(arrived.get().text().chars().filter(c -> c == '…')).hasSize(lost);
            assertThat(lost).as("a voice without any word is not heard").isLessThan(3);
            withLosses += lost > 0 ? 1 : 0;
        }
        assertThat(withLosses).isGreaterThan(50);
    }

    @ParameterizedTest
    @CsvSource({
        "10, 20, 10, true",
        "10, 20, 10.001, false",
        "20, 10, 10, true",
        "20, 10, 10.001, false"
    })
    void theShorterRangeOfVoiceAndEarsCounts(
            double voice, double ears, double distance, boolean isHeard) {
        var said =
                new Utterance(
                        "pond",
                        1,
                        ADA,
                        new double[3],
                        new Voice(voice, Double.POSITIVE_INFINITY),
                        "come");
        assertThat(said.at(BOB, ears, distance).isPresent()).isEqualTo(isHeard);
    }

    @Test
    void nobodyWithoutEarsHearsEvenAtTheSamePlace() {
        assertThat(said(1, "come").at(BOB, -1, 0)).isEmpty();
        assertThat(said(1, "come").at(BOB, 1, 0)).contains(new Arrived("come", 0));
    }

    @Test
    void theEventHasTheDirectionFromTheHearerAndTheDistance() {
        var said =
                new Utterance(
                        "pond",
                        4,
                        ADA,
                        new double[] {3, 2, -1},
                        new Voice(FAR, Double.POSITIVE_INFINITY),
                        "come");
        double[] at = {0, 2, 3};
        assertThat(said.event(said.whole(), Optional.of("ada"), at).fields())
                .isEqualTo(
                        Map.of(
                                "text",
                                "come",
                                "speaker",
                                "ada",
                                "direction",
                                List.of(0.6, 0.0, -0.8),
                                "distance",
                                5.0));
        assertThat(
                        said.event(new Arrived("…", 1), Optional.empty(), new double[] {3, 2, -1})
                                .fields())
                .isEqualTo(
                        Map.of(
                                "text",
                                "…",
                                "lost",
                                1,
                                "direction",
                                List.of(0.0, 0.0, 0.0),
                                "distance",
                                0.0));
    }
}
