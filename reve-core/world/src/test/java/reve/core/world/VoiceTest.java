// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

class VoiceTest {

    @Test
    void aWordArrivesWithTheProbabilityOfTheInverseSquareLaw() {
        var voice = new Voice(100, 8);
        assertThat(voice.clarity(0)).isEqualTo(1);
        assertThat(voice.clarity(8)).isCloseTo(1 / Math.E, within(1e-15));
        assertThat(voice.clarity(8 * Math.sqrt(Math.log(2)))).isCloseTo(0.5, within(1e-15));
        // Twice the distance is a quarter of the intensity: the logarithm is four times as large.
        assertThat(Math.log(voice.clarity(6)))
                .isCloseTo(4 * Math.log(voice.clarity(3)), within(1e-14));
    }

    @Test
    void withoutFadingNoWordIsLost() {
        assertThat(new Voice(100, Double.POSITIVE_INFINITY).clarity(1e100)).isEqualTo(1);
        assertThat(new Voice(Double.POSITIVE_INFINITY, 1e-100).clarity(1e100)).isZero();
    }

    @ParameterizedTest
    @ValueSource(doubles = {0, -1, Double.NaN, Double.NEGATIVE_INFINITY})
    void aDistanceThatIsNotPositiveIsRefused(double metres) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new Voice(metres, 1))
                .withMessage("range: " + metres + " m is not more than 0");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new Voice(1, metres))
                .withMessage("fading: " + metres + " m is not more than 0");
    }

    @Test
    void aHearingSensorSensesNoItemsAndKeepsItsKindInCopies() {
        Sensor ears = Sensor.hearing("ears", Double.POSITIVE_INFINITY);
        assertThat(ears.sensesItems()).isFalse();
        assertThat(ears.isUnlimited()).isFalse();
        assertThat(ears.withRange(3)).isEqualTo(Sensor.hearing("ears", 3));
        assertThat(ears.withEvery(2).hearing()).isTrue();
        assertThat(Sensor.sight("eyes", 3).hearing()).isFalse();
    }
}
