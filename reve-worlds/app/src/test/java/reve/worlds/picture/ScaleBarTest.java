// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import java.util.List;

class ScaleBarTest {

    @Test
    void theLengthIsRoundAndAtMostAQuarterOfTheWidth() {
        for (double metresPerPixel = 1e-9; metresPerPixel < 1e12; metresPerPixel *= 1.07) {
            ScaleBar bar = ScaleBar.of(metresPerPixel, 960);
            assertThat(bar.pixels()).isGreaterThan(240 / 2.5 - 1e-6).isLessThan(240 + 1e-6);
            assertThat(bar.pixels() * metresPerPixel)
                    .isCloseTo(bar.metres(), within(1e-9 * bar.metres()));
            double figure =
                    bar.metres() / Math.pow(10, Math.floor(Math.log10(bar.metres()) + 1e-9));
            assertThat(List.of(1.0, 2.0, 5.0)).anyMatch(round -> Math.abs(figure - round) < 1e-9);
        }
    }

    @Test
    void aBarThatFitsExactlyIsTaken() {
        for (int exponent = -8; exponent < 9; exponent++) {
            double metres = Double.parseDouble("1e" + exponent);
            assertThat(ScaleBar.of(metres / 240, 960).metres()).isEqualTo(metres);
            assertThat(ScaleBar.of(2 * metres / 240, 960).metres()).isEqualTo(2 * metres);
        }
    }

    @Test
    void theTextHasAFittingUnit() {
        assertThat(text(5)).isEqualTo("5 m");
        assertThat(text(200)).isEqualTo("200 m");
        assertThat(text(1e3)).isEqualTo("1 km");
        assertThat(text(5e5)).isEqualTo("500 km");
        assertThat(text(1e6)).isEqualTo("1e6 m");
        assertThat(text(2e11)).isEqualTo("2e11 m");
        assertThat(text(0.5)).isEqualTo("50 cm");
        assertThat(text(0.01)).isEqualTo("1 cm");
        assertThat(text(0.005)).isEqualTo("5 mm");
        assertThat(text(2e-4)).isEqualTo("200 µm");
        assertThat(text(1e-6)).isEqualTo("1 µm");
        assertThat(text(5e-7)).isEqualTo("5e-7 m");
    }

    private static String text(double metres) {
        return new ScaleBar(metres, 1).text();
    }
}
