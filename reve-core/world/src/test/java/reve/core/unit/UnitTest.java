// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.fail;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.aggregator.ArgumentsAccessor;
import org.junit.jupiter.params.provider.CsvFileSource;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;

import java.util.Locale;
import java.util.Random;

/** Units as texts. Exponents are in the order m kg s A K mol cd. */
class UnitTest {
    @ParameterizedTest(name = "{0} is {2} * m kg s A K mol cd ^ {1}")
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    1            |  0  0  0  0  0  0  0 | 1
                    m            |  1  0  0  0  0  0  0 | 1
                    kg           |  0  1  0  0  0  0  0 | 1
                    s            |  0  0  1  0  0  0  0 | 1
                    A            |  0  0  0  1  0  0  0 | 1
                    K            |  0  0  0  0  1  0  0 | 1
                    mol          |  0  0  0  0  0  1  0 | 1
                    cd           |  0  0  0  0  0  0  1 | 1
                    g            |  0  1  0  0  0  0  0 | 1e-3
                    t            |  0  1  0  0  0  0  0 | 1e3
                    mg           |  0  1  0  0  0  0  0 | 1e-6
                    cm           |  1  0  0  0  0  0  0 | 1e-2
                    km           |  1  0  0  0  0  0  0 | 1e3
                    µm           |  1  0  0  0  0  0  0 | 1e-6
                    min          |  0  0  1  0  0  0  0 | 60
                    h            |  0  0  1  0  0  0  0 | 3600
                    d            |  0  0  1  0  0  0  0 | 86400
                    l            |  3  0  0  0  0  0  0 | 1e-3
                    Hz           |  0  0 -1  0  0  0  0 | 1
                    N            |  1  1 -2  0  0  0  0 | 1
                    kN           |  1  1 -2  0  0  0  0 | 1e3
                    mN           |  1  1 -2  0  0  0  0 | 1e-3
                    J            |  2  1 -2  0  0  0  0 | 1
                    W            |  2  1 -3  0  0  0  0 | 1
                    Pa           | -1  1 -2  0  0  0  0 | 1
                    C            |  0  0  1  1  0  0  0 | 1
                    V            |  2  1 -3 -1  0  0  0 | 1
                    Ω            |  2  1 -3 -2  0  0  0 | 1
                    ohm          |  2  1 -3 -2  0  0  0 | 1
                    T            |  0  1 -2 -1  0  0  0 | 1
                    rad          |  0  0  0  0  0  0  0 | 1
                    deg          |  0  0  0  0  0  0  0 | 0.017453292519943295
                    °            |  0  0  0  0  0  0  0 | 0.017453292519943295
                    %            |  0  0  0  0  0  0  0 | 1e-2
                    m/s          |  1  0 -1  0  0  0  0 | 1
                    km/h         |  1  0 -1  0  0  0  0 | 0.2777777777777778
                    m/s^2        |  1  0 -2  0  0  0  0 | 1
                    m/s²         |  1  0 -2  0  0  0  0 | 1
                    m/s/s        |  1  0 -2  0  0  0  0 | 1
                    m/(s*s)      |  1  0 -2  0  0  0  0 | 1
                    m/s*s        |  1  0  0  0  0  0  0 | 1
                    s^-1         |  0  0 -1  0  0  0  0 | 1
                    1/s          |  0  0 -1  0  0  0  0 | 1
                    rad/s        |  0  0 -1  0  0  0  0 | 1
                    deg/s        |  0  0 -1  0  0  0  0 | 0.017453292519943295
                    N·s          |  1  1 -1  0  0  0  0 | 1
                    N*s          |  1  1 -1  0  0  0  0 | 1
                    N*s/m        |  0  1 -1  0  0  0  0 | 1
                    N/m          |  0  1 -2  0  0  0  0 | 1
                    kg/m         | -1  1  0  0  0  0  0 | 1
                    kg*m^2       |  2  1  0  0  0  0  0 | 1
                    kg*m^2/s^2   |  2  1 -2  0  0  0  0 | 1
                    g/cm^3       | -3  1  0  0  0  0  0 | 1e3
                    m^3/(kg*s^2) |  3 -1 -2  0  0  0  0 | 1
                    m^3/kg/s^2   |  3 -1 -2  0  0  0  0 | 1
                    """)
    void parsesDimensionAndScale(String text, String exponents, double scale) {
        Unit unit = Unit.parse(text);

        String[] expected = exponents.strip().split(" +");
        for (SiBase base : SiBase.values()) {
            assertThat(unit.exponent(base))
                    .as("exponent of %s", base.symbol())
                    .isEqualTo(Integer.parseInt(expected[base.ordinal()]));
        }
        assertThat(unit.scale()).isCloseTo(scale, within(4 * Math.ulp(scale)));
        assertThat(unit.symbol()).isEqualTo(text);
    }

    @ParameterizedTest(name = "{0}: {1}")
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    ''       | it is empty
                    foo      | `foo` is not a unit that is known here
                    m/foo    | `foo` is not a unit that is known here
                    degC     | `degC` is not a unit that is known here
                    °C       | not a plain multiple of SI units (for temperatures use K)
                    °C/m     | not a plain multiple of SI units
                    ln(m)    | `ln` is not a unit that is known here
                    ((m      | found the end, expected *, /, ^ or )
                    m*       | found the end, expected a unit such as m
                    /s       | column 1: found `/`, expected a unit
                    1//s     | column 3: found `/`, expected a unit
                    m^       | found the end, expected a whole number as exponent
                    m^^2     | column 3: found `^`, expected a whole number as exponent
                    kg m     | column 4: found `m`, expected *, /, ^ or the end
                    m^0.5    | column 4: found `.`, expected *, /, ^ or the end
                    m+1      | column 2: found `+`, expected *, /, ^ or the end
                    m2       | the number at column 2 is no exponent; write m^2
                    m^1/2    | exponents are whole
                    0*m      | a number in it must be above 0
                    m**2     | column 3: found `*`, expected a unit
                    m^200    | out of range
                    """)
    void refusesWithTheTextAndTheReason(String text, String reason) {
        assertThatThrownBy(() -> Unit.parse(text))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessageContaining("`" + text + "`")
                .hasMessageContaining(reason);
    }

    @ParameterizedTest(name = "{0}")
    @CsvFileSource(resources = "vectors.csv", numLinesToSkip = 1)
    void meansWhatItMeansToTheEngine(ArgumentsAccessor vector) {
        String text = vector.getString(0) == null ? "" : vector.getString(0);
        if (vector.getString(1).equals("refused")) {
            assertThatThrownBy(() -> Unit.parse(text))
                    .isInstanceOf(IllegalArgumentException.class)
                    .hasMessageStartingWith("unit `" + text + "`: ");
            return;
        }
        Unit unit = Unit.parse(text);
        assertThat(unit.scale()).isEqualTo(vector.getDouble(1));
        for (SiBase base : SiBase.values()) {
            assertThat(unit.exponent(base)).isEqualTo(vector.getInteger(2 + base.ordinal()));
        }
    }

    @Test
    void refusesHostileLengthAndNesting() {
        assertThatThrownBy(() -> Unit.parse("(".repeat(1_000_000)))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessageContaining("longer than 255 characters");
    }

    @Test
    void randomTextsAreUnitsOrRefusedInAnOrderlyWay() {
        long seed = Seed.of("units");
        var random = new Random(seed);
        String[] parts = {
            "m", "kg", "s", "°C", "deg", "k", "µ", "d", "ln", "%", "*", "·", "/", "^", "(", ")",
            "-", "1", "2", "²", "9", " ", "e", "π", "Ω", "inf"
        };
        int units = 0;
        for (int n = 0; n < 20_000; n++) {
            var text = new StringBuilder();
            for (int i = random.nextInt(8); i >= 0; i--) {
                text.append(parts[random.nextInt(parts.length)]);
            }
            try {
                Unit unit = Unit.parse(text.toString());
                assertThat(unit.scale()).as("%s, seed %d", text, seed).isPositive().isFinite();
                units++;
            } catch (IllegalArgumentException refused) {
                assertThat(refused).as("seed %d", seed).hasMessageContaining("unit `");
            } catch (RuntimeException | StackOverflowError crash) {
                fail("seed " + seed + ", unit `" + text + "`", crash);
            }
        }
        assertThat(units).as("units found, seed %d", seed).isPositive();
    }

    @Test
    void sameTextMeansTheSameInAnyLanguage() {
        Locale before = Locale.getDefault();
        try {
            Locale.setDefault(Locale.forLanguageTag("ru"));
            assertThat(Unit.parse("kN*s")).isEqualTo(Unit.parse("kN·s"));
        } finally {
            Locale.setDefault(before);
        }
    }

    @Test
    void convertsBetweenUnitsOfOneDimensionOnly() {
        Unit kmh = Unit.parse("km/h");
        Unit ms = Unit.parse("m/s");

        assertThat(kmh.toSi(36)).isCloseTo(10, within(1e-14));
        assertThat(kmh.convert(36, ms)).isCloseTo(10, within(1e-14));
        assertThat(ms.convert(10, kmh)).isCloseTo(36, within(1e-13));
        assertThat(kmh.convert(0.1, kmh)).isEqualTo(0.1);
        assertThat(kmh.sameDimension(ms)).isTrue();
        assertThatThrownBy(() -> kmh.convert(1, Unit.parse("kg")))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessage("unit km/h does not fit kg");
    }

    @Test
    void unitsAreEqualByWhatTheyMean() {
        assertThat(Unit.parse("N"))
                .isEqualTo(Unit.parse("kg*m/s^2"))
                .hasSameHashCodeAs(Unit.parse("kg*m/s^2"));
        assertThat(Unit.parse("km")).isNotEqualTo(Unit.parse("m"));
        assertThat(Unit.parse("rad")).isEqualTo(Unit.ONE);
    }

    @Test
    void exponentsCannotBeChangedFromOutside() {
        Unit unit = Unit.parse("m");
        unit.exponents()[0] = 7;
        assertThat(unit.exponent(SiBase.METRE)).isEqualTo(1);
    }

    @ParameterizedTest(name = "the SI unit of {0} is {1}")
    @CsvSource({
        "g, kg",
        "km/h, m/s",
        "N, N",
        "kN, kg*m/s^2",
        "kg*m/s, kg*m/s",
        "deg, rad",
        "°, rad",
        "rad, rad",
        "%, 1",
        "ms^-1, 1/s",
        "A/(cm^2*ms), A/(m^2*s)",
        "kPa, kg/(m*s^2)"
    })
    void theCoherentUnitOfADimensionHasASymbolThatCanBeRead(String text, String symbol) {
        Unit si = Unit.parse(text).si();
        assertThat(si.symbol()).isEqualTo(symbol);
        assertThat(si.scale()).isEqualTo(1);
        assertThat(Unit.parse(symbol)).isEqualTo(si);
        assertThat(si.sameDimension(Unit.parse(text))).isTrue();
    }

    @Test
    void unitsOfProductsAndQuotientsAreCoherent() {
        Unit newton = Unit.parse("N");
        assertThat(newton.times(Unit.parse("km"))).isEqualTo(Unit.parse("J"));
        assertThat(newton.per(Unit.parse("m")).symbol()).isEqualTo("kg/s^2");
        assertThat(newton.per(newton)).isEqualTo(Unit.ONE);
        Unit large = Unit.parse("m^127");
        assertThatThrownBy(() -> large.times(large)).hasMessageContaining("out of range");
    }
}
