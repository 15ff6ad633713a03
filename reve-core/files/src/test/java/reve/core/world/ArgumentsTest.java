// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;

import reve.core.access.DeclaredAction;
import reve.core.unit.Unit;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

class ArgumentsTest {
    private static final Action ACTION =
            new DeclaredAction(
                    "act",
                    "",
                    List.of(
                            Parameter.number("impulse", 3, Unit.parse("N*s"), ""),
                            Parameter.number("count", 1, Unit.ONE, ""),
                            Parameter.text("label", ""),
                            Parameter.truth("loud", "")),
                    List.of());

    private static Map<String, Object> good() {
        return new LinkedHashMap<>(
                Map.of("impulse", List.of(1, 2.5, -3L), "count", 4, "label", "a", "loud", true));
    }

    @Test
    void givesEveryArgumentItsType() throws ActionRefused {
        Arguments arguments = Arguments.check(ACTION, good());

        assertThat(arguments.vector("impulse")).containsExactly(1, 2.5, -3);
        assertThat(arguments.number("count")).isEqualTo(4);
        assertThat(arguments.text("label")).isEqualTo("a");
        assertThat(arguments.truth("loud")).isTrue();
    }

    @Test
    void vectorIsACopy() throws ActionRefused {
        Arguments arguments = Arguments.check(ACTION, good());
        arguments.vector("impulse")[0] = 99;
        assertThat(arguments.vector("impulse")).containsExactly(1, 2.5, -3);
    }

    @Test
    void askingForWhatIsNotThereIsAProgrammingError() throws ActionRefused {
        Arguments arguments = Arguments.check(ACTION, good());
        assertThatThrownBy(() -> arguments.text("count"))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessageContaining("`count`");
        assertThatThrownBy(() -> arguments.number("other"))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessageContaining("`other`");
    }

    @Test
    void refusesTextThatCannotBeWritten() {
        Map<String, Object> given = good();
        given.put("label", "half \ud800 pair");
        refused(
                given,
                "wrong-type",
                "`label` of action act takes Unicode text, found half of a surrogate pair");
    }

    @Test
    void refusesAMissingArgument() {
        Map<String, Object> given = good();
        given.remove("impulse");
        refused(given, "missing-argument", "action act needs `impulse`, 3 numbers in N*s");
    }

    @Test
    void refusesAnUnknownArgument() {
        Map<String, Object> given = good();
        given.put("force", 1);
        refused(
                given,
                "unknown-argument",
                "action act has no `force`; it takes `impulse`, `count`, `label`, `loud`");
    }

    @Test
    void refusesAnUnknownArgumentByTheBeginningOfItsName() {
        Map<String, Object> given = good();
        given.put("f".repeat(50_000), 1);
        refused(
                given,
                "unknown-argument",
                "action act has no `"
                        + "f".repeat(64)
                        + "…`; it takes `impulse`, `count`, `label`, `loud`");
    }

    @Test
    void refusesTheWrongNumberOfComponents() {
        refused(
                "impulse",
                List.of(1, 2),
                "wrong-components",
                "`impulse` of action act takes 3 numbers in N*s, found 2 numbers");
        refused(
                "count",
                List.of(1, 2),
                "wrong-components",
                "`count` of action act takes a number, found 2 numbers");
        refused(
                "count",
                List.of(),
                "wrong-components",
                "`count` of action act takes a number, found 0 numbers");
    }

    @Test
    void refusesTheWrongType() {
        refused(
                "impulse",
                "up",
                "wrong-type",
                "`impulse` of action act takes 3 numbers in N*s, found a text");
        refused(
                "impulse",
                List.of(1, true, 2),
                "wrong-type",
                "`impulse` of action act takes 3 numbers in N*s, found a truth value");
        refused(
                "impulse",
                List.of(List.of(1), 2, 3),
                "wrong-type",
                "`impulse` of action act takes 3 numbers in N*s, found a list");
        refused("label", 3, "wrong-type", "`label` of action act takes a text, found a number");
        refused(
                "label",
                "x".repeat(1025),
                "wrong-type",
                "`label` of action act takes a text of at most 1024 characters, found 1025");
        refused(
                "loud",
                Map.of(),
                "wrong-type",
                "`loud` of action act takes true or false, found something else");
    }

    @Test
    void refusesWhatIsNotFinite() {
        for (double bad :
                new double[] {Double.NaN, Double.POSITIVE_INFINITY, Double.NEGATIVE_INFINITY}) {
            refused(
                    "impulse",
                    List.of(0, bad, 0),
                    "not-finite",
                    "`impulse` of action act takes finite numbers, found " + bad);
        }
    }

    private static void refused(String name, Object value, String code, String message) {
        Map<String, Object> given = good();
        given.put(name, value);
        refused(given, code, message);
    }

    private static void refused(Map<String, Object> given, String code, String message) {
        ActionRefused refused =
                catchThrowableOfType(ActionRefused.class, () -> Arguments.check(ACTION, given));
        assertThat(refused.code()).isEqualTo(code);
        assertThat(refused).hasMessage(message);
    }
}
