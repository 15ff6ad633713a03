// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.unit.Unit;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Optional;

class ExpressionTest {
    private static final WorldPrototype PROTOTYPE =
            WorldPrototype.standard("si-f64")
                    .extendedBy(
                            List.of(
                                    new PropertyDescriptor(
                                            "range",
                                            "body",
                                            ScalarType.F64,
                                            1,
                                            Unit.parse("km"),
                                            Optional.empty(),
                                            "")))
                    .withSymbols(
                            List.of(
                                    new SymbolDescriptor(
                                            "limit", SymbolType.NUMBER, Unit.parse("km/h"), "")));
    private static final Scope SCOPE = Scope.ofItem(PROTOTYPE, "body");
    private static final Scope ACTION =
            Scope.ofAction(
                    PROTOTYPE,
                    "body",
                    List.of(
                            Parameter.number("heat", 1, Unit.parse("K"), ""),
                            Parameter.text("label", "")));

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", PROTOTYPE, arena);
    private final Item ball =
            world.add(
                    ItemDefinition.named("ball")
                            .at(1, 2, 3)
                            .symbol("class", "toy")
                            .symbol("age", 3)
                            .symbol("lit", true)
                            .symbol("limit", 36)
                            .symbol("wind-up", "slow")
                            .symbol("tags", List.of("red", "round"))
                            .physics("mass", 2)
                            .physics("velocity", 3, 0, 4)
                            .physics("range", 1.5)
                            .build());
    private final Item floor = world.add(ItemDefinition.named("floor").build());

    @AfterEach
    void free() {
        arena.close();
    }

    @ParameterizedTest(name = "{0} is in {1}")
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    physics.mass                                  | kg
                    -physical.location[1]                         | m
                    norm(physics.velocity)                        | m/s
                    physics.range                                 | m
                    semantic.limit                                | m/s
                    physical.location[1] - 0.5                    | m
                    2 + physics.mass                              | kg
                    norm(physics.velocity) - semantic.limit       | m/s
                    subtract(physical.location, [0, 1, 0])        | m
                    distance(physical.location, [0, -1, 0])       | m
                    scale(physics.velocity, physics.mass)         | kg*m/s
                    dot(physics.velocity, physics.velocity)       | m^2/s^2
                    physics.range / norm(physics.velocity)        | s
                    physics.mass > 1.0 ? physics.mass : 0.0       | kg
                    rotate(physical.orientation, physics.velocity)| m/s
                    math.abs(physics.mass)                        | kg
                    physics.mass / physical.volume                | kg/m^3
                    """)
    void theUnitOfAResultFollowsFromThePropertiesThatItReads(String text, String unit)
            throws Exception {
        assertThat(SCOPE.compile(text).unit()).map(Unit::symbol).hasValue(unit);
    }

    /** A number in the text may stand for a quantity, so the unit of its product is not known. */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "9.81 * physics.mass",
                "physics.mass + norm(physics.velocity)",
                "1.0",
                "item.name",
                "physics.mass > 1.0",
                "math.sqrt(physics.mass)",
                "[1.0].map(x, physics.mass)[0]"
            })
    void aUnitThatDoesNotFollowIsNotGuessed(String text) throws Exception {
        assertThat(SCOPE.compile(text).unit()).isEmpty();
    }

    private static String evaluated(String text, Item item) throws Exception {
        return String.valueOf(SCOPE.compile(text).evaluate(SCOPE.bindings().of(item)));
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '"',
            value = {
                "physics.mass > 1                              | true",
                "physics.mass * 2 + 1                          | 5.0",
                "2 * physics.mass - 1 / physics.mass           | 3.5",
                "physics.velocity[2] / 2                       | 2.0",
                "norm(physics.velocity)                        | 5.0",
                "distance(physical.location, [1, 2, 0])        | 3.0",
                "dot(physics.velocity, [2, 5, 1])              | 10.0",
                "add(physics.velocity, [1, 1, 1])              | [4.0, 1.0, 5.0]",
                "subtract([1, 1, 1], physics.velocity)         | [-2.0, 1.0, -3.0]",
                "scale(physics.velocity, 2)                    | [6.0, 0.0, 8.0]",
                "rotate(physical.orientation, [0, 0, 1])       | [0.0, 0.0, 1.0]",
                "rotate([0, 1, 0, 0], [1, 2, 3])               | [-1.0, 2.0, -3.0]",
                "math.sqrt(16.0) + math.greatest(1.0, 2.5)     | 6.5",
                "semantic.age + 1                              | 4.0",
                "semantic.class == 'toy' && semantic.lit       | true",
                "semantic['wind-up'].startsWith('sl')          | true",
                "'round' in semantic.tags                      | true",
                "size(semantic.tags)                           | 2.0",
                "physics.velocity.exists(v, v > 3.5)           | true",
                "physics.velocity.map(v, v * v)                | [9.0, 0.0, 16.0]",
                "has(semantic.torn) ? 'torn' : item.name       | ball",
                "'limit' in semantic                           | true",
                "'torn' in semantic                            | false",
                "physical.colour == '#ccccccff'                | true",
                "physical.movable                              | true",
                "physical.volume                               | 0.0",
                "physical.substance                            | \"\"",
                "physics.mass == 2 && 3 != physics.mass         | true",
                "item.name.matches('^b[a-z]{3}$')              | true",
                "item.name.matches('^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$') | false",
                "item.name.matches('(?i)^BALL$')               | true",
                "size({'a': 1, 'b': item.name})                | 2.0",
                "item.kind                                     | body"
            })
    void expressionHasThatValue(String text, String value) throws Exception {
        assertThat(evaluated(text, ball)).isEqualTo(value);
    }

    @Test
    void numbersAreInSiUnitsWhateverTheUnitTheyAreKeptIn() throws Exception {
        assertThat(evaluated("physics.range", ball)).isEqualTo("1500.0");
        assertThat(evaluated("semantic.limit", ball)).isEqualTo("10.0");
        assertThat(
                        catchThrowableOfType(
                                EvaluationException.class,
                                () -> evaluated("semantic.limit", floor)))
                .hasMessageContaining("missing");
        assertThat(evaluated("semantic['limit']", ball)).isEqualTo("10.0");
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            quoteCharacter = '"',
            value = {
                "physics.temprature > 350    | 7  | unknown name `temprature`",
                "physics.mass > 'heavy'      | 13 | `>` does not go with (number, text)",
                "null > physics.mass         | 5  | `>` does not go with (no value, number)",
                "physics.mass >              | 14 | ends too early",
                "physics.mass = 3            | 13 | `=` makes no sense here; write `==` to compare",
                "true and physics.mass > 3   | 5  | `and` makes no sense here; write `&&`",
                "true or physics.mass > 3    | 5  | `or` makes no sense here; write `||`",
                "physics.mass > 1 kg         | 17 | `kg` makes no sense here; numbers have no unit"
                        + " here, and properties are in SI units: write `> 1`, not `> 1 kg`",
                "physics.mass > 1 heavy      | 17 | `heavy` makes no sense here",
                "physics.velocity > 3        | 17 | `>` does not go with (list of numbers, number)",
                "weather == 'rain'           | 0  | "
                        + "unknown name `weather`; known are item, physical, physics, semantic",
                "semantic.limit == 'fast'    | 15 | does not go with (number, text)",
                "getHours()                  | 8  | `getHours` does not go with ()",
                "timestamp('2020-01-01')     | 9  | unknown name `timestamp`",
                "actor.name                  | 0  | unknown name `actor`",
                "has(semantic.limit)         | 3  | write `'note' in semantic` for a declared"
                        + " symbol",
                "{'a': 1}                    | 0  | gives a map",
                "physics                     | 0  | gives a physics",
                "physics.velocity[3] > 0     | 17 | there is no [3]: `physics.velocity` has"
                        + " components: 3, expected an index from 0 to 2",
                "physical.orientation[4]     | 21 | expected an index from 0 to 3",
                "physics.velocity[-1]        | 18 | there is no [-1]",
                "semantic.tags[0] + [1][1]   | 23 | there is no [1]: `[…]` has components: 1",
                "rotate([0,0,0,1], [1,2,3])[3] | 27 | `rotate(…)` has components: 3",
                "scale(physics.velocity,2)[3] | 26 | expected an index from 0 to 2",
                "item.name.matches(item.kind) | 18 | the pattern of `matches` is computed, expected"
                        + " a constant text in quotes",
                "matches(item.name, 'a' + 'b') | 19 | the pattern of `matches` is computed",
                "item.name.matches('((a{1000}){1000}){1000}') | 18 | the pattern has 10",
                "item.name.matches('(a{99}){99}') | 18 | steps with its repetitions written out,"
                        + " expected 1000 at most: repeat less often",
                "item.name.matches('(?i)[a-ÿ]') | 18 | the pattern ignores the case of characters"
                        + " beyond",
                "item.name.matches(r'(?mi:\\x{1C80})') | 18 | expected only ASCII with `(?i)`",
                "item.name.matches('a(b')    | 18 | the pattern is broken: missing closing ) `a(b`",
                "size({item.name: 1})        | 6  | the key of a map is computed, expected a"
                        + " constant"
            })
    void whatCannotBeUnderstoodIsRefusedAtItsPlace(String text, int offset, String message) {
        var refused = catchThrowableOfType(ExpressionException.class, () -> SCOPE.compile(text));

        assertThat(refused).hasMessageContaining(message);
        assertThat(refused.offset()).isEqualTo(offset);
    }

    @Test
    void whatAgentsSayIsNoPattern() {
        var refused =
                catchThrowableOfType(
                        ExpressionException.class,
                        () -> ACTION.compile("item.name.matches(label)"));

        assertThat(refused).hasMessageStartingWith("the pattern of `matches` is computed");
        assertThat(refused.offset()).isEqualTo(18);
    }

    @Test
    void variableOfALoopMayHaveTheNameOfAParameterOfAnotherLength() throws Exception {
        Scope scope =
                Scope.ofAction(
                        PROTOTYPE, "body", List.of(Parameter.number("way", 2, Unit.ONE, "")));

        assertThat(scope.compile("[[1, 2, 3]].map(way, way[2])").evaluate(scope.bindings()))
                .isEqualTo(List.of(3.0));
        assertThat(
                        catchThrowableOfType(
                                ExpressionException.class, () -> scope.compile("way[2] > 1")))
                .hasMessageContaining("`way` has components: 2");
    }

    @Test
    void unknownNameIsAnsweredWithTheKnownOnes() {
        var refused =
                catchThrowableOfType(
                        ExpressionException.class, () -> SCOPE.compile("physical.place"));

        assertThat(refused)
                .hasMessage(
                        "unknown name `place`; known here: "
                                + "colour, location, movable, orientation, size, substance, volume");
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "semantic.torn",
                "semantic['torn']",
                "semantic.tags[2]",
                "1.0 / 0.0",
                "1 / 0",
                "semantic.age + 'x'",
                "semantic.class > 2",
                "add([1, 2], [1])",
                "norm(['a'])",
                "[1, {}]"
            })
    void whatHasNoValueSaysWhy(String text) throws Exception {
        Expression expression = SCOPE.compile(text);

        var failed =
                catchThrowableOfType(
                        EvaluationException.class,
                        () -> expression.evaluate(SCOPE.bindings().of(ball)));

        assertThat(failed.getMessage()).startsWith("`" + text + "`: ").doesNotContain("<input>");
    }

    @Test
    void sceneryHasNoPhysics() throws Exception {
        assertThat(evaluated("has(physics.mass)", floor)).isEqualTo("false");
        Expression mass = SCOPE.compile("physics.mass");
        assertThat(
                        catchThrowableOfType(
                                EvaluationException.class,
                                () -> mass.evaluate(SCOPE.bindings().of(floor))))
                .hasMessageContaining("mass");
    }

    @Test
    void costIsBounded() throws Exception {
        String numbers = "[0,1,2,3,4,5,6,7,8,9]";
        Expression loops =
                SCOPE.compile(
                        numbers
                                + ".all(a, "
                                + numbers
                                + ".all(b, "
                                + numbers
                                + ".all(c, a + b + c >= 0)))");

        assertThat(
                        catchThrowableOfType(
                                EvaluationException.class,
                                () -> loops.evaluate(SCOPE.bindings().of(ball))))
                .hasMessageContaining("1000");
        assertThat(
                        catchThrowableOfType(
                                ExpressionException.class,
                                () -> SCOPE.compile("1 + ".repeat(150) + "1")))
                .hasMessageContaining("250");
        assertThat(
                        catchThrowableOfType(
                                ExpressionException.class,
                                () -> SCOPE.compile("1+".repeat(501) + "1")))
                .hasMessageContaining("1000");
        assertThat(
                        catchThrowableOfType(
                                ExpressionException.class,
                                () -> SCOPE.compile("(".repeat(400) + "1" + ")".repeat(400))))
                .isNotNull();
    }

    @Test
    void typeIsKnownBeforeEvaluation() throws Exception {
        assertThat(SCOPE.compile("physics.mass > 1").type()).isEqualTo(ExpressionType.TRUTH);
        assertThat(SCOPE.compile("1 + 2").type()).isEqualTo(ExpressionType.NUMBER);
        assertThat(SCOPE.compile("item.name").type()).isEqualTo(ExpressionType.TEXT);
        assertThat(SCOPE.compile("physics.velocity").type()).isEqualTo(ExpressionType.LIST);
        assertThat(SCOPE.compile("semantic.limit").type()).isEqualTo(ExpressionType.NUMBER);
        assertThat(SCOPE.compile("semantic.age").type()).isEqualTo(ExpressionType.ANY);
    }

    @Test
    void whatAnExpressionReadsIsKnown() throws Exception {
        assertThat(
                        ACTION.compile(
                                        "physics.mass > heat && semantic['wind-up'] == label &&"
                                                + " actor.physics.velocity[0] > 1 && semantic.limit > 2"
                                                + " && [1].all(x, x > 0)")
                                .uses())
                .containsExactly(
                        "actor.physics.velocity",
                        "heat",
                        "label",
                        "physics.mass",
                        "semantic.limit",
                        "semantic.wind-up");
    }

    @Test
    void actionsSeeTheirActorAndTheirParameters() throws Exception {
        Bindings bindings =
                ACTION.bindings()
                        .of(floor)
                        .withItem("actor", ball)
                        .with("heat", 350.0)
                        .with("label", "x");

        assertThat(ACTION.compile("actor.physics.mass * heat").evaluate(bindings)).isEqualTo(700.0);
        assertThat(ACTION.compile("actor.name + label + item.name").evaluate(bindings))
                .isEqualTo("ballxfloor");
        assertThat(ACTION.compile("actor.semantic.age").evaluate(bindings)).isEqualTo(3.0);
        assertThat(ACTION.compile("actor.physical.location").evaluate(bindings))
                .isEqualTo(List.of(1.0, 2.0, 3.0));
    }

    @Test
    void expressionIsUnderstoodOnce() throws Exception {
        assertThat(SCOPE.compile("physics.mass")).isSameAs(SCOPE.compile("physics.mass"));
    }
}
