// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.World;

import java.nio.charset.StandardCharsets;

/** Properties of the designer that refer to items. */
class ReferencePropertiesTest {
    private static final String GEARBOXES =
            """
            properties:
              - {name: pair, kind: gearbox, components: 2, refersTo: wheel, doc: Driving and driven.}
              - {name: teeth, kind: wheel, type: u32}
              - {name: frame, kind: gearbox, refersTo: body}
              - {name: box, kind: label, refersTo: gearbox}
            items:
              - {name: note, kind: label, physics: {box: gears}}
              - {name: gears, kind: gearbox, physics: {pair: [small, big], frame: case}}
              - {name: small, kind: wheel, physics: {teeth: 8}}
              - {name: big, kind: wheel, physics: {teeth: 40}}
              - {name: case, physics: {mass: 1}}
            """;

    private static WorldDescription parse(String rest) throws WorldFileException {
        return WorldFile.parse("w", ("reve: 1\nname: w\n" + rest).getBytes(StandardCharsets.UTF_8));
    }

    @Test
    void aKindOfItsOwnRefersToItemsThatComeLater() throws Exception {
        WorldDescription description = parse(GEARBOXES);
        PropertyDescriptor pair =
                description.prototype().properties().stream()
                        .filter(property -> property.name().equals("pair"))
                        .findFirst()
                        .orElseThrow();
        assertThat(pair.type()).isEqualTo(ScalarType.REF);
        assertThat(pair.components()).isEqualTo(2);
        assertThat(pair.refersTo()).contains("wheel");
        assertThat(pair.doc()).isEqualTo("Driving and driven.");
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            var gears = world.find("gears").orElseThrow();
            assertThat(gears.physics().references("pair"))
                    .containsExactly(
                            world.find("small").orElseThrow().id(),
                            world.find("big").orElseThrow().id());
            assertThat(world.find("note").orElseThrow().physics().reference("box"))
                    .isEqualTo(gears.id());
        }
    }

    @Test
    void theyAreWrittenAsTheyWereRead() throws Exception {
        WorldDescription world = parse(GEARBOXES);
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
        assertThat(WorldWriter.write(again)).isEqualTo(WorldWriter.write(world));
        assertThat(again.items().get(1).references().get("pair")).containsExactly("small", "big");
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    {name: to, kind: body, refersTo: body}                ! 3:32 ! kind: items of kind `body` have no references of your own; declare a kind of your own, which refers to them
                    {name: to, kind: world, refersTo: body}               ! 3:32 ! kind: items of kind `world` have no references of your own; declare a kind of your own, which refers to them
                    {name: to, kind: pipe, refersTo: bodi}                ! 3:48 ! refersTo: there are no items of a kind `bodi`; kinds are body, pipe, spring, surface; did you mean `body`?
                    {name: to, kind: pipe, refersTo: world}               ! 3:48 ! refersTo: there are no items of a kind `world`; kinds are body, pipe, spring, surface
                    {name: to, kind: pipe, refersTo: body, unit: m}       ! 3:54 ! unit: a property with `refersTo` holds references and no numbers; leave it out
                    {name: to, kind: pipe, refersTo: body, type: u32}     ! 3:54 ! type: a property with `refersTo` holds references and no numbers; leave it out
                    {name: to, kind: pipe, refersTo: body, min: 0}        ! 3:54 ! min: a property with `refersTo` holds references and no numbers; leave it out
                    {name: to, kind: pipe, refersTo: 3}                   ! 3:48 ! refersTo: found number 3, expected a text; put it in quotes
                    {name: to, kind: pipe, refersTo: body, components: 17} ! 3:66 ! components: found number 17, expected at most 16
                    """)
    void aWrongDeclarationIsRefusedAtItsPlace(String property, String place, String message) {
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () -> parse("properties: [ " + property + " ]\n"));
        assertThat(refused.problems())
                .extracting(Problem::toString)
                .contains("w:" + place + ": " + message);
    }

    @Test
    void aNameThatIsTakenIsRefused() {
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () ->
                                parse(
                                        """
                                        properties:
                                          - {name: to, kind: pipe, refersTo: body}
                                          - {name: to, kind: pipe, refersTo: body}
                                          - {name: mass, kind: pipe, refersTo: body}
                                        """));
        assertThat(refused.problems())
                .extracting(Problem::line)
                .as(refused.getMessage())
                .containsExactly(5, 6);
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    ends: [a, b]     ! 9:50 ! ends[1]: no item is named `b`
                    ends: a          ! 9:46 ! ends: found text `a`, expected a list of 2 names of items of kind tank
                    ends: [a]        ! 9:46 ! ends: found a list of 1, expected a list of 2 names of items of kind tank
                    ends: [a, ball]  ! 9:50 ! ends[1]: `ball` is a body, expected a tank
                    width: 3         ! 9:30 ! a pipe needs `ends`: 2 names of items of kind tank
                    """)
    void aWrongReferenceIsRefusedAtItsPlace(String physics, String place, String message) {
        String text =
                """
                properties:
                  - {name: level, kind: tank}
                  - {name: ends, kind: pipe, components: 2, refersTo: tank}
                  - {name: width, kind: pipe}
                items:
                  - {name: a, kind: tank, physics: {level: 1}}
                  - {name: pipe, kind: pipe, physics: {%s}}
                  - {name: ball, physics: {mass: 1}}
                """
                        .formatted(physics);
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> parse(text));
        assertThat(refused).as(text).isNotNull();
        assertThat(refused.problems())
                .extracting(Problem::toString)
                .as(text)
                .containsExactly("w:" + place + ": " + message);
    }
}
