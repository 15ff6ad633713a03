// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.WorldPrototype;

import java.nio.charset.StandardCharsets;

/**
 * The keys of bodies that touch. They include terrains, and properties that only some worlds have.
 */
class ContactKeysTest {
    private static WorldDescription parse(String items) throws WorldFileException {
        return WorldFile.parse(
                "w", ("reve: 1\nname: w\n" + items).getBytes(StandardCharsets.UTF_8));
    }

    @Test
    void aTerrainIsAMeshOfTwoTrianglesForEachCell() throws WorldFileException {
        ItemDefinition ground =
                parse(
                                """
                                items:
                                  - name: ground
                                    physical:
                                      shape: terrain
                                      size: [4, 2]
                                      heights: [[0, 10 cm, 0], [1, 2, 3]]
                                """
                                        .replace("10 cm", "0.1"))
                        .items()
                        .getFirst();
        Mesh mesh = (Mesh) ground.shape();
        float[] vertices = new float[18];
        mesh.vertices().get(vertices);
        assertThat(vertices)
                .containsExactly(-2, 0, -1, 0, 0.1f, -1, 2, 0, -1, -2, 1, 1, 0, 2, 1, 2, 3, 1);
        int[] triangles = new int[12];
        mesh.triangles().get(triangles);
        assertThat(triangles).containsExactly(0, 3, 1, 1, 3, 4, 1, 4, 2, 2, 4, 5);
    }

    @Test
    void aTerrainHasRowsOfEqualLength() {
        assertThatThrownBy(() -> terrain("[[0, 0, 0], [0, 0]]"))
                .isInstanceOf(WorldFileException.class);
        assertThatThrownBy(() -> terrain("[[0], [0]]"))
                .hasMessageContaining("expected at least two lists of at least two heights");
        assertThatThrownBy(
                        () -> parse("items: [{name: t, physical: {shape: terrain, size: 1 1 m}}]"))
                .hasMessageContaining("shape terrain needs `heights`");
    }

    private static WorldDescription terrain(String heights) throws WorldFileException {
        return parse(
                "items: [{name: t, physical: {shape: terrain, size: [1, 1], heights: "
                        + heights
                        + "}}]");
    }

    /** Other worlds keep their images, because they do not have these properties. */
    @Test
    void aWorldHasThePropertiesOfContactsThatItsItemsSet() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        prefabs:
                          ghost: {physics: {mass: 1, passesLayers: [0, 5]}}
                        items:
                          - {name: casper, like: ghost}
                          - {name: plate, physics: {mass: 0, touchSensor: 1}}
                        """);
        assertThat(world.items().getFirst().physics("passesLayers").orElseThrow())
                .containsExactly(33);
        assertThat(world.prototype().find("body", "passesLayers")).isPresent();
        assertThat(world.prototype().find("body", "touchCount")).as("of sensors").isPresent();
        assertThat(world.prototype().find("body", "touchLayer")).isEmpty();
        assertThat(parse("items: [{name: a, physics: {mass: 1}}]").prototype().properties())
                .doesNotContainAnyElementsOf(world.prototype().propertiesOnDemand());
    }

    @Test
    void aSavedWorldHasThePropertiesOfContactsThatAreZeroAtAllItems() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        rules: {pressed: physics.touchCount > 0, dreams: physics.asleep == 1}
                        items:
                          - {name: lamp, physical: {location: [0, 1, 0]}}
                          - {name: plate, physics: {mass: 2, touchLayer: 0, touchCount: 0}}
                          - {name: ball, physics: {mass: 1, rollingFriction: 0.5, spinFriction: 0, asleep: 0}}
                        """);
        assertThat(world.prototype().propertiesOnDemand().stream())
                .filteredOn(world.prototype().properties()::contains)
                .hasSize(5);
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
    }

    @Test
    void aWorldWhoseLastJointIsGoneKeepsItsRulesOfJoints() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        rules: {strained: {is: "physics.jointForce[0] > 1.0", kind: joint}}
                        items: [{name: a, physics: {mass: 1}}]
                        """);
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(again.rules()).hasSize(1);
        assertThat(again.prototype().kinds()).contains(WorldPrototype.JOINT);
    }

    @Test
    void aWorldHasThePropertiesOfJointsThatItsItemsSetOrItsRulesRead() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        rules: {worn: {is: "physics.angleFriction > 1.0", kind: joint}}
                        items:
                          - {name: a, physics: {mass: 0}}
                          - {name: b, physics: {mass: 1}}
                          - name: axle
                            kind: joint
                            physics: {joined: [a, b], jointType: hinge, angleDamping: 2 N*m*s/rad, rotorInertia: 0}
                        """);
        WorldPrototype prototype = world.prototype();
        assertThat(prototype.find("joint", "angleDamping")).isPresent();
        assertThat(prototype.find("joint", "rotorInertia")).isPresent();
        assertThat(prototype.find("joint", "angleFriction")).as("of the rule").isPresent();
        assertThat(prototype.find("joint", "angleStiffness")).isEmpty();
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(again.prototype().properties()).isEqualTo(prototype.properties());
        assertThatThrownBy(
                        () ->
                                parse(
                                        "items: [{name: a, kind: joint, physics: {jointType: hinge,"
                                                + " angleDamping: -1}}]"))
                .hasMessageContaining("angleDamping: found -1.0, expected 0 or more [N*m*s]");
    }

    @Test
    void aWorldHasTheKindGearIfAnItemIsAGear() throws WorldFileException {
        String items =
                """
                items:
                  - {name: a, physics: {mass: 0}}
                  - {name: b, physics: {mass: 1}}
                  - {name: c, physics: {mass: 1}}
                  - {name: one, kind: joint, physics: {joined: [a, b], jointType: hinge}}
                  - {name: two, kind: joint, physics: {joined: [a, c], jointType: rope, ropeLength: 2 m}}
                """;
        assertThat(parse(items).prototype().kinds())
                .contains(WorldPrototype.JOINT)
                .doesNotContain(WorldPrototype.GEAR);
        assertThat(parse(items).items().getLast().physics("jointType").orElseThrow())
                .containsExactly(6);
        String gear =
                "  - {name: pair, kind: gear, physics: {geared: [one, two], gearRatio: -2,"
                        + " offsetAngle: 90 deg}}\n";
        WorldDescription world = parse(items + gear);
        assertThat(world.items().getLast().references().get("geared"))
                .containsExactly("one", "two");
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
        assertThat(WorldWriter.write(again)).isEqualTo(WorldWriter.write(world));
        assertThatThrownBy(() -> parse(items + gear.replace("two]", "b]")))
                .hasMessageContaining("geared[1]: `b` is a body, expected a joint");
        assertThatThrownBy(() -> parse(items + gear.replace("geared: [one, two], ", "")))
                .hasMessageContaining("a gear needs `geared`: The two joints.");
    }

    @Test
    void aPropertyThatTheWorldDeclaresIsItsOwn() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        properties: [{name: touchLayer, kind: body, unit: K}]
                        items: [{name: a, physics: {mass: 1, touchLayer: 300}}]
                        """);
        assertThat(world.prototype().find("body", "touchLayer").orElseThrow().unit().symbol())
                .isEqualTo("K");
    }

    @Test
    void aLayerIsAWholeNumberUpTo31() {
        for (String wrong : new String[] {"32", "-1", "0.5"}) {
            assertThatThrownBy(
                            () ->
                                    parse(
                                            "items: [{name: a, physics: {mass: 1, passesLayers: [1,"
                                                    + " "
                                                    + wrong
                                                    + "]}}]"))
                    .as(wrong)
                    .hasMessageContaining("expected numbers of layers from 0 to 31");
        }
    }
}
