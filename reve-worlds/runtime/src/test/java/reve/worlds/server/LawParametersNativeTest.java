// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.offset;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.pe.PhysicsException;
import reve.pe.adapter.FolderParameters;

import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;

/** Problems of laws and parameters are reported at their places in the world file. */
class LawParametersNativeTest {
    private static WorldDescription world(String laws) throws WorldFileException {
        return WorldFile.parse(
                "w", ("reve: 1\nname: w\nlaws:\n" + laws + "\n").getBytes(StandardCharsets.UTF_8));
    }

    private static String refusal(String laws) throws WorldFileException {
        WorldDescription world = world(laws);
        PhysicsException refused =
                catchThrowableOfType(
                        PhysicsException.class, () -> new Simulation(world, Pacing.FAST).close());
        assertThat(refused).as(laws).isNotNull();
        assertThat(refused.getMessage())
                .doesNotContain("libvesper")
                .doesNotContain(".so")
                .doesNotContain("build");
        return refused.getMessage();
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    - sphere_contcat ! w:4:3: law library 'sphere_contcat' was not found among the laws that ship; did you mean `sphere_contact`?
                    - Drag           ! w:4:3: law library 'Drag' was not found among the laws that ship; did you mean `drag`?
                    - {name: sphere_contact, parameters: {stifness: 1}} ! w:4:39: law sphere_contact has no parameter 'stifness'; did you mean 'stiffness'?
                    - {name: sphere_contact, parameters: {stiffness: -1}} ! w:4:39: law sphere_contact: parameter stiffness is -1, expected
                    - {name: sphere_contact, parameters: {stiffness: 1e4, dampingRatio: 7}} ! w:4:55: law sphere_contact: parameter dampingRatio is 7, expected
                    """)
    void eachIsNamedAtItsPlace(String laws, String message) throws WorldFileException {
        assertThat(refusal(laws)).startsWith(message).doesNotContain("\n");
    }

    @Test
    void aLawThatIsLikeNoOtherIsToldWhichThereAre() throws WorldFileException {
        assertThat(refusal("- telekinesis"))
                .startsWith(
                        "w:4:3: law library 'telekinesis' was not "
                                + "found among the laws that ship; known are ")
                .contains("drag, ", "hooke_spring");
    }

    @Test
    void aParameterInAWrongUnitIsRefused() throws WorldFileException {
        assertThat(
                        refusal(
                                "- name: sphere_contact\n  parameters:\n    friction: 0.5\n"
                                        + "    stiffness: 1 kg*K\n    dampingRatio: 3 s"))
                .isEqualTo(
                        "w:7:5: law sphere_contact: parameter stiffness: unit kg*K does not fit"
                                + " N/m\n"
                                + "w:8:5: law sphere_contact: parameter dampingRatio: unit s does not"
                                + " fit 1");
    }

    @Test
    void aFileOfParametersHasUnits(@TempDir Path folder) throws Exception {
        Path file = Files.writeString(folder.resolve("drag.yaml"), "a: 20 km/h\nb: 3\n");
        FolderParameters read = LawParameters.inFile("drag", file);
        assertThat(read.values()).containsOnlyKeys("a", "b").containsEntry("b", 3.0);
        assertThat(read.values().get("a")).isCloseTo(5.5556, offset(1e-4));
    }

    @Test
    void mistakesInAFileOfParametersHaveTheirPlaces(@TempDir Path folder) throws Exception {
        Path file = folder.resolve("sphere_contact.yaml");
        Files.writeString(file, "a: [1, 2]\nb: 3 kg/\n");
        assertThatThrownBy(() -> LawParameters.inFile("sphere_contact", file))
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining(
                        "sphere_contact.yaml:1:4: a: found 2 numbers, expected 3 numbers")
                .hasMessageNotContaining("Exception");
        Files.writeString(file, "stiffness: 1 kg*K\n");
        FolderParameters wrong = LawParameters.inFile("sphere_contact", file);
        try (var simulation = new Simulation(world("- sphere_contact"), Pacing.FAST)) {
            var laws = simulation.physics().laws().loaded();
            assertThatThrownBy(() -> wrong.check().check(laws))
                    .isInstanceOf(PhysicsException.class)
                    .hasMessageEndingWith(
                            "sphere_contact.yaml:1:1: law sphere_contact: parameter stiffness: unit"
                                    + " kg*K does not fit N/m");
        }
    }

    @Test
    void aParameterInAnotherUnitOfTheSameIsTaken() throws WorldFileException {
        try (var simulation =
                new Simulation(
                        world(
                                "- {name: sphere_contact, "
                                        + "parameters: {stiffness: 1 N/mm, dampingRatio: 30 %}}"),
                        Pacing.FAST)) {
            assertThat(simulation.physics().laws().libraries().getFirst().parameters())
                    .containsEntry("stiffness", 1000.0)
                    .containsEntry("dampingRatio", 0.3);
        }
    }

    /** The folder may belong to others, who could exchange the file after it was checked. */
    @Test
    void aLinkInThePlaceOfTheFileIsNotFollowed(@TempDir Path folder) throws Exception {
        Path secret = Files.writeString(folder.resolve("secret"), "password: hunter2\n");
        Path file = Files.createSymbolicLink(folder.resolve("drag.yaml"), secret);
        assertThatThrownBy(() -> LawParameters.inFile("drag", file))
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining("expected a regular file, found a symbolic link")
                .message()
                .doesNotContain("password", "hunter2");
    }
}
