// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.image.PrototypeCodec;
import reve.core.image.Trees;
import reve.core.world.PropertyDescriptor;

import java.nio.charset.StandardCharsets;

/** Properties of the designer that are sums of what laws add. */
class AccumulatedPropertiesTest {
    private static final String HEATED =
            """
            properties:
              - {name: heating, kind: body, unit: W, access: accumulate, doc: Heat flows.}
              - {name: flux, kind: body, components: 3, unit: W/m^2, access: accumulate}
              - {name: power, kind: body, unit: W, access: read_write}
            """;

    private static WorldDescription parse(String rest) throws WorldFileException {
        return WorldFile.parse("w", ("reve: 1\nname: w\n" + rest).getBytes(StandardCharsets.UTF_8));
    }

    private static PropertyDescriptor property(WorldDescription world, String name) {
        return world.prototype().find("body", name).orElseThrow();
    }

    private static void assertRefused(String text, String problem) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> parse(text));
        assertThat(refused).as(text).isNotNull();
        assertThat(refused.problems())
                .extracting(Problem::toString)
                .as(text)
                .containsExactly("w:" + problem);
    }

    @Test
    void theyAreWrittenAsTheyWereRead() throws Exception {
        WorldDescription world = parse(HEATED + "items: [{name: a, physics: {heating: 0}}]\n");
        assertThat(property(world, "heating").accumulated()).isTrue();
        assertThat(property(world, "flux").accumulated()).isTrue();
        assertThat(property(world, "flux").components()).isEqualTo(3);
        assertThat(property(world, "power").accumulated()).isFalse();
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
        assertThat(WorldWriter.write(again)).isEqualTo(WorldWriter.write(world));
        byte[] image = Trees.write(PrototypeCodec.write(world.prototype()));
        assertThat(PrototypeCodec.read(Trees.read(image)).properties())
                .isEqualTo(world.prototype().properties());
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    {name: a, kind: body, access: acumulate}                ! 3:45 ! access: found text `acumulate`, expected one of `read_write`, `accumulate`; did you mean `accumulate`?
                    {name: a, kind: body, type: i32, access: accumulate}    ! 3:43 ! type: found text `i32`, expected real, because laws sum only real numbers
                    {name: a, kind: body, min: 0, access: accumulate}       ! 3:37 ! min: a sum of what laws add has no least value; leave it out
                    {name: a, kind: a, refersTo: body, access: accumulate}  ! 3:50 ! access: a property with `refersTo` holds references and no numbers; leave it out
                    {name: rollingFriction, kind: body, access: accumulate} ! 3:59 ! access: `rollingFriction` of kind body is a standard property, whose access the engine knows; leave it out
                    """)
    void aWrongDeclarationIsRefusedAtItsPlace(String property, String place, String message) {
        assertRefused("properties: [ " + property + " ]\n", place + ": " + message);
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    {physics: {heating: 3 W}}               ! 8:34 ! heating: found text `3 W`, expected no value, because it is the sum of what laws add in each step; set a property that a law adds to it
                    {physics: {flux: [0, 0, 1]}}            ! 8:31 ! flux: found a list of 3, expected no value, because it is the sum of what laws add in each step; set a property that a law adds to it
                    {physics: {mass: 1}, access: {go: {effects: [{set: physics.heating, to: 3}]}}} ! 8:65 ! set: heating is the sum of what laws add in each step, so an action cannot set it; set a property that a law adds to it
                    {physics: {mass: 1}, access: {go: {effects: [{create: {name: b, physics: {mass: 1}}, with: {physics.heating: 3}}]}}} ! 8:123 ! physics.heating: heating is the sum of what laws add in each step, so an action cannot set it; set a property that a law adds to it
                    """)
    void onlyLawsSetThem(String item, String place, String message) {
        assertRefused(
                HEATED + "items:\n  - {name: a, " + item.strip().substring(1) + "\n",
                place + ": " + message);
    }

    @Test
    void aWorldThatRanKeepsTheSumsOfItsLastStep() throws Exception {
        String text =
                HEATED
                        + """
                        frame: {age: 7}
                        items: [{name: a, physics: {heating: 3 W, flux: [0, 0, 1]}}]
                        """;
        WorldDescription world = parse(text);
        assertThat(world.warnings()).isEmpty();
        assertThat(world.items().getFirst().physics("heating").orElseThrow()).containsExactly(3);
        assertThat(WorldWriter.write(WorldFileTest.parse(WorldWriter.write(world))))
                .isEqualTo(WorldWriter.write(world))
                .contains("heating: 3", "flux: [0, 0, 1]");
    }
}
