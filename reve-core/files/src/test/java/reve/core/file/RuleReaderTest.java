// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.rule.ExpressionType;
import reve.core.rule.Rule;
import reve.core.rule.Scope;
import reve.core.rule.SymbolSource;
import reve.core.world.SymbolType;
import reve.core.world.WorldPrototype;

import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Map;

/** Types of symbols in world files, and rules that set them. */
class RuleReaderTest {
    private static final String HEAD = "reve: 1\nname: w\n";

    private static WorldDescription parse(String text) throws WorldFileException {
        return WorldFile.parse("w", (HEAD + text).getBytes(StandardCharsets.UTF_8));
    }

    @Test
    void rulesAndTypesOfSymbolsAreRead() throws Exception {
        WorldDescription world =
                parse(
                        """
                        symbols:
                          tags: {type: list, doc: What it is like.}
                          limit: {type: number, unit: km/h}
                        rules:
                          heavy: physics.mass > 10
                          warning: {is: "semantic.heavy ? 'heavy' : 'light'", class: crate, doc: For carriers.}
                          taut: {is: physics.length > 1, kind: spring}
                        items:
                          - {name: sign, semantic: {limit: 10 m/s, tags: [round, 2, true]}}
                        """);

        assertThat(world.prototype().symbol("tags").orElseThrow().type())
                .isEqualTo(SymbolType.LIST);
        assertThat(world.items().getFirst().symbols())
                .containsEntry("limit", 36.0)
                .containsEntry("tags", List.of("round", 2.0, true));
        assertThat(world.rules())
                .extracting(Rule::symbol)
                .containsExactly("heavy", "warning", "taut");
        Rule warning = world.rules().get(1);
        assertThat(warning.itemClass()).contains("crate");
        assertThat(((SymbolSource.Formula) warning.source()).expression().text())
                .isEqualTo("semantic.heavy ? 'heavy' : 'light'");
        assertThat(world.rules().get(2).kind()).isEqualTo("spring");
    }

    @Test
    void rulesAndTypesAreWrittenAsTheyWereRead() throws Exception {
        String text =
                WorldWriter.write(
                        parse(
                                """
                                symbols: {limit: {type: number, unit: km/h, doc: At most.}, tags: {type: list}}
                                rules:
                                  heavy: physics.mass > 10
                                  taut: {is: physics.length > 1, kind: spring, class: rope, doc: Of ropes.}
                                """));

        assertThat(text).contains("heavy: physics.mass > 10", "class: rope", "unit: km/h");
        assertThat(
                        WorldWriter.write(
                                WorldFile.parse("again", text.getBytes(StandardCharsets.UTF_8))))
                .isEqualTo(text);
    }

    @Test
    void moreRulesThanMayBeAreRefusedBeforeTheyAreUnderstood() {
        var text = new StringBuilder("rules:\n");
        for (int i = 0; i < 20_000; i++) {
            text.append("  r").append(i).append(": physics.mass >< ").append(i).append('\n');
        }

        var refused = catchThrowableOfType(WorldFileException.class, () -> parse(text.toString()));

        assertThat(refused.problems())
                .extracting(Problem::toString)
                .containsExactly("w:4:3: rules: found a mapping, expected at most 256 in it");
    }

    @Test
    void onlySoManyDifferentExpressionsOfActionsAreUnderstood() throws Exception {
        var problems = new Problems("w");
        List<Node> whens =
                List.copyOf(
                        YamlReader.read(HEAD + "when: [a, b, a, c]", problems, new Allowance(100))
                                .get("when")
                                .orElseThrow()
                                .children());
        var operands =
                new OperandReader(
                        null,
                        problems,
                        Map.of(),
                        Scope.ofItem(WorldPrototype.standard("si-f64"), "body"),
                        new Allowance(2));
        String[] texts = {"1 < 2", "2 < 3", "1 < 2", "3 < 4"};
        for (int i = 0; i < 3; i++) {
            assertThat(operands.expression(whens.get(i), texts[i], 0, ExpressionType.TRUTH))
                    .isPresent();
        }

        assertThat(operands.expression(whens.get(3), texts[3], 0, ExpressionType.TRUTH)).isEmpty();
        assertThat(catchThrowableOfType(WorldFileException.class, problems::throwIfAny))
                .hasMessageContaining(
                        "the actions have more than 2 different expressions, which is the limit");
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '~',
            textBlock =
                    """
                    rules: {hot: physics.temperatur > 3}      ! 3:21 ! hot: unknown name `temperatur`; known here: acceleration, angularVelocity, appliedForce, charge, dragCoefficient, externalForce, inertia, linearDragCoefficient, mass, radius, torque, velocity
                    rules: {hot: "physics.mass >"}            ! 3:29 ! hot: the expression ends too early
                    rules: {hot: {is: 3}}                     ! 3:19 ! is: found number 3, expected a text; put it in quotes
                    rules: {hot: {}}                          ! 3:14 ! hot: found neither, expected one of `is` and `java`
                    rules: {hot: {is: "true", java: test.loud}} ! 3:14 ! hot: found both, expected one of `is` and `java`
                    rules: {hot: {java: test.lowd}}           ! 3:21 ! java: there is no symbol `test.lowd`; the plugins have test.loud; did you mean `test.loud`?
                    rules: {hot: {java: test.levitate}}       ! 3:21 ! java: there is no symbol `test.levitate`; the plugins have test.loud
                    rules: {hot: {is: "true", kind: sprung}}  ! 3:33 ! kind: there is no kind `sprung`; did you mean `spring`?
                    rules: {up: "physics.velocity[3] > 0"}    ! 3:31 ! up: there is no [3]: `physics.velocity` has components: 3, expected an index from 0 to 2
                    rules: {b: "item.name.matches(item.kind)"} ! 3:31 ! b: the pattern of `matches` is computed, expected a constant text in quotes, such as '^a+$': compare computed texts with `==`, `startsWith`, `endsWith` or `contains`
                    rules: {b: "item.name.matches('((a{1000}){1000}){1000}')"} ! 3:31 ! b: the pattern has 1007015013 steps with its repetitions written out, expected 1000 at most: repeat less often, or with `*` and `+`
                    rules: {name: "'x'"}                      ! 3:9  ! symbol name is a standard one; a rule cannot give it
                    rules: {a: semantic.b, b: "true"}         ! 3:9  ! rule a reads what rule b gives, which comes later
                    rules: {a: semantic.a}                    ! 3:9  ! rule a reads what it gives itself
                    symbols: {name: {}}                       ! 3:11 ! symbol name is derived by the world; it cannot be declared
                    symbols: {a: {type: text, unit: m}}       ! 3:11 ! symbol a: only a number has a unit
                    symbols: {a: {type: real}}                ! 3:21 ! type: found text `real`, expected one of `text`, `number`, `truth`, `list`
                    ~symbols: {a: {type: number}}\nrules: {a: item.name}~ ! 4:12 ! a: is a text, the symbol is declared as a number
                    ~symbols: {a: {type: truth}}\nitems: [{name: i, semantic: {a: 3}}]~ ! 4:30 ! item i: a is a number, declared as a truth value
                    ~symbols: {a: {type: number, unit: m}}\nitems: [{name: i, semantic: {a: 3 s}}]~ ! 4:33 ! a: unit s does not fit m
                    """)
    void refuses(String text, String place, String message) {
        var refused =
                catchThrowableOfType(
                        WorldFileException.class, () -> parse(text.replace("\\n", "\n")));

        assertThat(refused).as(text).isNotNull();
        assertThat(refused.problems())
                .extracting(Problem::toString)
                .containsExactly("w:" + place + ": " + message);
    }
}
