// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.frame.TimeBudget;
import reve.core.frame.Timing;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.unit.Unit;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.Arguments;
import reve.core.world.Colour;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.awt.image.BufferedImage;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;

import javax.imageio.ImageIO;

/** The meaning of valid world files. */
class WorldFileTest {
    static WorldDescription parse(String yaml) throws WorldFileException {
        return WorldFile.parse("world.yaml", yaml.getBytes(StandardCharsets.UTF_8));
    }

    static Path root() {
        return Path.of(
                Objects.requireNonNull(
                        System.getProperty("reve.root"),
                        "run with -Dreve.root=<folder of the repository>"));
    }

    private static ItemDefinition onlyItem(String physics) throws WorldFileException {
        return parse("reve: 1\nname: w\nitems:\n  - {name: a, physics: {" + physics + "}}\n")
                .items()
                .getFirst();
    }

    @Test
    void meshesAndTexturesComeFromFilesBesideTheWorld(@TempDir Path folder) throws Exception {
        Files.createDirectory(folder.resolve("models"));
        Files.writeString(folder.resolve("models/t.obj"), "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
        ImageIO.write(
                new BufferedImage(2, 3, BufferedImage.TYPE_INT_RGB),
                "png",
                folder.resolve("tile.png").toFile());
        Path file =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: w
                        items:
                          - name: a
                            physical: {shape: mesh, file: models/t.obj}
                          - name: b
                            physical:
                              shape: mesh
                              file: models/t.obj
                              material: {texture: tile.png, roughness: 0.2, metallic: 1, colour: "#ff0000"}
                        """);
        List<ItemDefinition> items = WorldFile.load(file).items();

        assertThat(items.get(0).shape().size(1)).isEqualTo(2);
        assertThat(items.get(1).shape()).isSameAs(items.get(0).shape());
        assertThat(items.get(0).colour()).isEqualTo(Colour.DEFAULT);
        assertThat(items.get(1).colour()).isEqualTo(Colour.WHITE);
        Material material = items.get(1).material().orElseThrow();
        assertThat(material.texture().orElseThrow().height()).isEqualTo(3);
        assertThat(List.of(material.roughness(), material.metallic())).containsExactly(0.2, 1.0);
        assertThat(material.colour()).isEqualTo(Colour.parse("#ff0000"));

        String written = new ItemWriter(WorldPrototype.standard("si-f64")).write(items.get(1));
        ItemDefinition again =
                WorldFile.parseItem(
                        "b",
                        written,
                        WorldPrototype.standard("si-f64"),
                        new Assets(new WorldFolder(folder)));
        assertThat(((Mesh) again.shape()).file()).contains("models/t.obj");
        assertThat(again.material().orElseThrow().texture().orElseThrow().file())
                .contains("tile.png");
    }

    private static ItemDefinition solid(String physical, String physics) throws WorldFileException {
        return parse(
                        "reve: 1\nname: w\nitems:\n  - {name: a, physical: {"
                                + physical
                                + "}, physics: {"
                                + physics
                                + "}}\n")
                .items()
                .getFirst();
    }

    @Test
    void massAndInertiaFollowFromDensity() throws WorldFileException {
        ItemDefinition brick = solid("shape: box, size: [1, 2, 3]", "density: 10 kg/m^3");
        assertThat(brick.physics("mass").orElseThrow()).containsExactly(60);
        assertThat(brick.physics("inertia").orElseThrow())
                .containsExactly(new double[] {65, 50, 25}, within(1e-12));
        ItemDefinition ball = solid("shape: sphere, radius: 2", "density: 1");
        assertThat(ball.physics("radius").orElseThrow()).containsExactly(2);
        assertThat(ball.physics("mass").orElseThrow()[0]).isCloseTo(33.5103216, within(1e-6));
    }

    @Test
    void aWorldMayDeclareADensityOfItsOwn() throws WorldFileException {
        ItemDefinition item =
                parse(
                                """
                                reve: 1
                                name: w
                                properties: [{name: density, kind: body, unit: kg/m^3}]
                                items: [{name: a, physics: {mass: 1, density: 7 g/l}}]
                                """)
                        .items()
                        .getFirst();
        assertThat(item.physics("density").orElseThrow()).containsExactly(7);
        assertThat(item.physics("mass").orElseThrow()).containsExactly(1);
    }

    @Test
    void densitiesThatCannotBeUsedAreRefusedWithTheReason() {
        String corner =
                "shape: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "
                        + "triangles: [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]]";
        assertThatThrownBy(() -> solid("shape: plane, size: [1, 1]", "density: 1"))
                .hasMessageContaining("density: a plane has no volume");
        assertThatThrownBy(() -> solid("shape: sphere, radius: 1", "density: 1, mass: 3"))
                .hasMessageContaining("density: `mass` is given too");
        assertThatThrownBy(() -> solid("shape: sphere, radius: 1", "density: -1"))
                .hasMessageContaining("density: -1.0, expected a positive one");
        assertThatThrownBy(() -> solid(corner, "density: 1"))
                .hasMessageContaining("centre of mass is at (0.2500 0.2500 0.2500) m");
        assertThatThrownBy(() -> solid(corner.replace("0, 0, 0]", "-1, -1, -1]"), "density: 1"))
                .hasMessageContaining("products of inertia yz zx xy are (");
        assertThatThrownBy(() -> solid(corner.replace(", [1, 2, 3]", ""), "density: 1"))
                .hasMessageContaining("the mesh is open at the edge");
    }

    @Test
    void smallestFileIsAnEmptyWorldWithDefaults() throws WorldFileException {
        WorldDescription world = parse("reve: 1\nname: nothing\n");

        assertThat(world.name()).isEqualTo("nothing");
        assertThat(world.prototype().name()).isEqualTo("si-f64");
        assertThat(world.timing()).isEqualTo(Timing.DEFAULT);
        assertThat(world.laws()).isEmpty();
        assertThat(world.items()).isEmpty();
        assertThat(world.camera()).isEmpty();
        assertThat(world.agents()).isEqualTo(AgentPolicy.none());
    }

    @Test
    void jsonIsValidToo() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        {
                        \t"reve": 1, "name": "json", "doc": "\\u00e9\\/", "frame": {"rate": 50, "steps": 2},
                        \t"items": [{"name": "a", "physics": {"mass": 2, "velocity": [1, 2.5e0, -3]}}]
                        }\
                        """);

        assertThat(world.name()).isEqualTo("json");
        assertThat(world.doc()).isEqualTo("é/");
        assertThat(world.timing()).isEqualTo(new Timing(50, 2));
        assertThat(world.items().getFirst().physics("velocity").orElseThrow())
                .containsExactly(1, 2.5, -3);
    }

    @Test
    void minifiedJsonOnOneLongLineIsRead() throws WorldFileException {
        var json = new StringBuilder("{\"reve\":1,\"name\":\"j\",\"items\":[");
        for (int i = 0; i < 5000; i++) {
            json.append(i == 0 ? "" : ",").append("{\"name\":\"i").append(i).append("\"}");
        }
        assertThat(parse(json + "]}").items()).hasSize(5000);
    }

    @Test
    void numbersAreConvertedOnceToTheUnitOfTheProperty() throws WorldFileException {
        assertThat(number(onlyItem("mass: 3"), "mass")).isEqualTo(3);
        assertThat(number(onlyItem("mass: 3 kg"), "mass")).isEqualTo(3);
        assertThat(number(onlyItem("mass: 500 g"), "mass")).isEqualTo(0.5);
        assertThat(number(onlyItem("mass: 2 t"), "mass")).isEqualTo(2000);
        assertThat(number(onlyItem("mass: \"7\""), "mass")).isEqualTo(7);
        assertThat(number(onlyItem("mass: +.5e1 kg"), "mass")).isEqualTo(5);
        assertThat(number(onlyItem("mass: [4]"), "mass")).isEqualTo(4);
        assertThat(number(onlyItem("mass: 0x10"), "mass")).isEqualTo(16);
        assertThat(number(onlyItem("mass: 12345678901234567890123"), "mass"))
                .isEqualTo(12345678901234567890123.0);
    }

    @Test
    void vectorsAreListsOrTextsWithOneUnitBehindThem() throws WorldFileException {
        for (String written :
                List.of(
                        "[0, 3.6, -36]",
                        "0 3.6 -36",
                        "0 3.6 -36 m/s",
                        "\"[0, 3.6, -36] m/s\"",
                        "\"0, 3.6, -36 m/s\"",
                        "0 12.96 -129.6 km/h",
                        "\"[0 12.96 -129.6] km/h\"")) {
            assertThat(onlyItem("velocity: " + written).physics("velocity").orElseThrow())
                    .as(written)
                    .containsExactly(new double[] {0, 3.6, -36}, within(1e-14));
        }
    }

    @Test
    void anglesAreNumbersAndDegreesFitWhereTheUnitIsOne() throws WorldFileException {
        ItemDefinition item =
                parse(
                                """
                                reve: 1
                                name: w
                                items:
                                  - name: a
                                    physical: {orientation: {axis: [0, 0, 2], angle: 90 deg}}
                                    physics: {angularVelocity: 0 0 180 deg/s}
                                """)
                        .items()
                        .getFirst();

        double half = Math.sqrt(0.5);
        assertThat(item.orientation())
                .containsExactly(new double[] {0, 0, half, half}, within(1e-15));
        assertThat(item.physics("angularVelocity").orElseThrow())
                .containsExactly(new double[] {0, 0, Math.PI}, within(1e-15));
    }

    /** An item may lose its physics while its world runs; the saved world is still valid. */
    @Test
    void aWorldThatRanMayHaveAnActionThatNeedsLostPhysics() throws WorldFileException {
        String items = "items: [{name: a, access: {push: {effects: [{impulse: [1, 0, 0]}]}}}]\n";
        WorldDescription saved = parse("reve: 1\nname: w\nframe: {age: 5}\n" + items);
        assertThat(saved.warnings())
                .singleElement()
                .asString()
                .contains("the item has no `physics`, so this action could never work");
        assertThat(saved.items()).hasSize(1);
    }

    @Test
    void lawParametersBecomeSi() throws WorldFileException {
        List<LawReference> laws =
                parse(
                                """
                                reve: 1
                                name: w
                                laws:
                                  - newton_motion
                                  - name: drag
                                    parameters: {density: 1.2 g/l, wind: 36 km/h, factor: 3, turn: 180 deg, up: [0, 1, 0], gust: 36 0 72 km/h}
                                """)
                        .laws();
        assertThat(laws.getFirst())
                .isEqualTo(new LawReference("newton_motion", Map.of(), "world.yaml:4:5"));
        LawReference drag = laws.getLast();
        assertThat(drag.name()).isEqualTo("drag");
        assertThat(drag.place()).isEqualTo("world.yaml:5:11");
        assertThat(drag.parameters())
                .isEqualTo(
                        Map.of(
                                "density", 1.2, "wind", 10.0, "factor", 3.0, "turn", Math.PI,
                                "up_x", 0.0, "up_y", 1.0, "up_z", 0.0, "gust_x", 10.0, "gust_y",
                                0.0, "gust_z", 20.0));
        assertThat(drag.mentions())
                .containsEntry(
                        "wind",
                        new LawReference.Mention(
                                "world.yaml:6:36", Optional.of(Unit.parse("km/h"))))
                .containsEntry(
                        "factor", new LawReference.Mention("world.yaml:6:51", Optional.empty()));
    }

    @Test
    void budgetsOfLawsAreReadAndWritten() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        reve: 1
                        name: w
                        laws:
                          - newton_motion
                          - {name: drag, budget: 2 ms}
                          - name: hooke_spring
                            budget: {time: 300 us, frames: 5, then: skip-steps, every: 4}
                        """);
        assertThat(world.laws())
                .extracting(LawReference::budget)
                .containsExactly(
                        Optional.empty(),
                        Optional.of(new TimeBudget(2_000_000, 10, TimeBudget.Response.WARN, 2)),
                        Optional.of(new TimeBudget(300_000, 5, TimeBudget.Response.SKIP_STEPS, 4)));
        assertThat(parse(WorldWriter.write(world)).laws())
                .extracting(LawReference::budget)
                .isEqualTo(world.laws().stream().map(LawReference::budget).toList());
    }

    @Test
    void designersPropertiesExtendThePrototype() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        reve: 1
                        name: w
                        prototype: si-f32
                        properties:
                          - {name: temperature, kind: body, unit: K, doc: Of all of it.}
                          - {name: lit, kind: lamp, type: u32}
                          - {name: travelled, kind: body, type: real, components: 2, unit: km}
                        items:
                          - {name: a, physics: {temperature: 300, travelled: 500 1500 m}}
                          - {name: b, kind: lamp, physics: {lit: 4294967295}}
                        """);

        var temperature = world.prototype().find("body", "temperature").orElseThrow();
        assertThat(temperature.type()).isEqualTo(ScalarType.F32);
        assertThat(temperature.unit()).isEqualTo(Unit.parse("K"));
        assertThat(temperature.doc()).isEqualTo("Of all of it.");
        assertThat(world.items().get(0).physics("travelled").orElseThrow())
                .containsExactly(0.5, 1.5);
        assertThat(number(world.items().get(1), "lit")).isEqualTo(4294967295.0);
    }

    @Test
    void shapesAreReadInMetres() throws WorldFileException {
        List<ItemDefinition> items =
                parse(
                                """
                                reve: 1
                                name: w
                                items:
                                  - {name: s, physical: {shape: sphere, radius: 25 cm}}
                                  - {name: b, physical: {shape: box, size: 1 2 3 dm}}
                                  - {name: p, physical: {shape: plane, size: [5, 6]}}
                                  - name: m
                                    physical:
                                      shape: mesh
                                      vertices: [[0, 0, 0], [1, 0, 0], 0 100 0 cm]
                                      triangles: [[0, 1, 2]]
                                  - {name: n, physical: {location: [1, 2, 3]}}
                                  - {name: c, physical: {shape: capsule, radius: 1 cm, height: 1 m}}
                                  - {name: d, physical: {shape: cylinder, radius: 2, height: 0.1}}
                                """)
                        .items();

        assertThat(items.get(5).shape()).isEqualTo(Shape.capsule(0.01, 1));
        assertThat(items.get(6).shape()).isEqualTo(Shape.cylinder(2, 0.1));
        assertThat(items.get(0).shape()).isEqualTo(Shape.sphere(0.25));
        assertThat(items.get(1).shape()).isEqualTo(Shape.box(0.1, 0.2, 3 * 0.1));
        assertThat(items.get(2).shape()).isEqualTo(Shape.plane(5, 6));
        assertThat(items.get(3).shape().size(0)).isEqualTo(1);
        assertThat(items.get(3).shape().size(1)).isEqualTo(1);
        assertThat(items.get(4).shape()).isEqualTo(Shape.none());
        assertThat(items.get(4).location()).containsExactly(1, 2, 3);
    }

    /** A world has the kind joint only if it uses it, so that other worlds keep their images. */
    @Test
    void jointsAreAKindOfTheWorldsThatUseThem() throws WorldFileException {
        WorldDescription with =
                parse(
                        """
                        reve: 1
                        name: w
                        items:
                          - {name: frame, physics: {mass: 0}}
                          - {name: door, physics: {mass: 20}}
                          - name: hinge
                            kind: joint
                            physics:
                              joined: [frame, door]
                              jointType: hinge
                              axis: [0, 1, 0]
                              angleLimits: 0 90 deg
                        """);
        ItemDefinition hinge = with.items().get(2);
        assertThat(hinge.physics("jointType").orElseThrow()).containsExactly(3);
        assertThat(hinge.references().get("joined")).containsExactly("frame", "door");
        WorldDescription without =
                parse(
                        """
                        reve: 1
                        name: w
                        items:
                          - {name: a, physics: {mass: 0}}
                        """);
        assertThat(with.prototype().kinds()).contains("joint");
        assertThat(without.prototype().kinds()).doesNotContain("joint");
        assertThatThrownBy(
                        () ->
                                parse(
                                        """
                                        reve: 1
                                        name: w
                                        items:
                                          - {name: a, physics: {mass: 0}}
                                          - {name: b, physics: {mass: 1}}
                                          - {name: j, kind: joint,
                                             physics: {joined: [a, b], jointType: hing}}
                                        """))
                .hasMessageContaining(
                        "jointType: found text `hing`, expected one of fixed, ball, hinge, slider,"
                                + " distance, rope, six-axis");
    }

    @Test
    void aCapsuleIsAtLeastAsHighAsItsEnds() {
        assertThatThrownBy(() -> solid("shape: capsule, radius: 1, height: 1.5", "mass: 1"))
                .hasMessageContaining(
                        "height of capsule is 1.5, expected at least twice the radius, 2.0 m");
    }

    @Test
    void itemsMayReferToItemsThatComeLater() throws WorldFileException {
        WorldDescription description =
                parse(
                        """
                        reve: 1
                        name: w
                        items:
                          - {name: s, kind: spring, physics: {end1: a, end2: b}}
                          - {name: f, kind: surface, physics: {vertices: [c, a, b]}}
                          - {name: a, physics: {mass: 1}}
                          - {name: b, physics: {mass: 1}}
                          - {name: c, physics: {mass: 0}}
                        """);
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            Item spring = world.find("s").orElseThrow();
            assertThat(world.item(spring.physics().reference("end2")).name()).isEqualTo("b");
            assertThat(world.find("f").orElseThrow().physics().references("vertices"))
                    .extracting(id -> world.item(id).name())
                    .containsExactly("c", "a", "b");
        }
    }

    @Test
    void oneDescriptionBuildsAnyNumberOfEqualWorlds() throws WorldFileException {
        WorldDescription description =
                parse(
                        """
                        reve: 1
                        name: w
                        constants: {gravity: [0, -9.81, 0]}
                        items: [{name: a, physics: {mass: 2}}, {name: b}]
                        """);
        try (var arena = new OffHeapArena()) {
            for (World world : List.of(description.build(arena), description.build(arena))) {
                assertThat(world.find("world").orElseThrow().physics().vector("gravity"))
                        .containsExactly(0, -9.81, 0);
                assertThat(world.items()).extracting(Item::name).containsExactly("world", "a", "b");
                assertThat(world.find("b").orElseThrow().physics().isEmpty()).isTrue();
            }
        }
    }

    @Test
    void agentsGetTheBodiesAndTheTemplateOfTheFile() throws WorldFileException {
        AgentPolicy agents =
                parse(
                                """
                                reve: 1
                                name: w
                                agents:
                                  bodies: [b, a]
                                  body: {physical: {shape: sphere, radius: 1}, semantic: {class: guest}}
                                  places: [[0, 1, 2], 10 20 30 cm]
                                  items: 3
                                  eventBytes: 512
                                  most: 7
                                items: [{name: a}, {name: b}]
                                """)
                        .agents();

        assertThat(agents.bodies()).containsExactly("b", "a");
        assertThat(agents.items()).isEqualTo(3);
        assertThat(agents.worldItems()).isEqualTo(1000);
        assertThat(agents.eventBytes()).isEqualTo(512);
        assertThat(agents.worldEventBytes()).isEqualTo(262_144);
        assertThat(agents.most()).isEqualTo(7);
        assertThat(agents.places())
                .containsExactly(
                        new AgentPolicy.Place(0, 1, 2), new AgentPolicy.Place(0.1, 0.2, 0.3));
        ItemDefinition guest = agents.template().orElseThrow().renamed("ada");
        assertThat(guest.shape()).isEqualTo(Shape.sphere(1));
        assertThat(guest.hasPhysics()).isFalse();
        assertThat(guest.symbols()).containsEntry("class", "guest");
    }

    @Test
    void declaredActionsWorkOnTheBuiltWorld() throws Exception {
        WorldDescription description =
                parse(
                        """
                        reve: 1
                        name: w
                        items:
                          - name: a
                            physics: {mass: 2}
                            access:
                              kick:
                                doc: A kick.
                                parameters:
                                  by: {components: 3, unit: kN*s, doc: In the world's axes.}
                                  why: {type: text}
                                effects:
                                  - impulse: $by
                                  - {set: physics.charge, to: 3 mC}
                                  - {set: physical.colour, to: "#112233"}
                                  - {symbol: reason, to: $why}
                                  - {symbol: kicked, to: true}
                                  - raise: kicked
                        """);
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            Item item = world.find("a").orElseThrow();
            Action kick = item.access().find("kick").orElseThrow();
            assertThat(kick.doc()).isEqualTo("A kick.");
            assertThat(kick.parameters())
                    .containsExactly(
                            Parameter.number("by", 3, Unit.parse("kN*s"), "In the world's axes."),
                            Parameter.text("why", ""));

            new ActionCall(
                            world,
                            1,
                            item,
                            Optional.empty(),
                            Arguments.check(
                                    kick, Map.of("by", List.of(0.001, 0.002, 0), "why", "fun")))
                    .perform(kick);

            assertThat(item.physics().vector("velocity")).containsExactly(0.5, 1, 0);
            assertThat(item.physics().scalar("charge")).isEqualTo(0.003);
            assertThat(item.physical().colour()).hasToString("#112233ff");
            assertThat(item.semantic().symbols())
                    .containsEntry("reason", "fun")
                    .containsEntry("kicked", true);
            assertThat(world.events()).hasSize(1);
        }
    }

    @Test
    void plainWordsOfOldYamlAreTexts() throws WorldFileException {
        assertThat(
                        parse("reve: 1\nname: no\nitems: [{name: yes, semantic: {a: on, b: 1:30}}]")
                                .items()
                                .getFirst()
                                .symbols())
                .containsEntry("a", "on")
                .containsEntry("b", "1:30");
    }

    @Test
    void loadReadsAFileAndNamesItInProblems(@TempDir Path folder) throws Exception {
        Path good =
                Files.writeString(folder.resolve("good.yaml"), "\uFEFFreve: 1\nname: w\ndoc: é\n");
        Path bad = Files.writeString(folder.resolve("bad.yaml"), "reve: 2\nname: x\n");

        assertThat(WorldFile.load(good).doc()).isEqualTo("é");
        assertThatThrownBy(() -> WorldFile.load(bad))
                .isInstanceOf(WorldFileException.class)
                .hasMessage(
                        bad
                                + ":1:7: reve: found number 2, expected 1, the format version "
                                + "that is read here");
    }

    @Test
    void springOrbitIsThePapersFigureTen() throws Exception {
        WorldDescription world = WorldFile.load(root().resolve("worlds/spring-orbit/world.yaml"));

        assertThat(world.prototype().name()).isEqualTo("si-f64");
        assertThat(world.timing().dtSeconds()).isEqualTo(1.0 / 240);
        assertThat(world.laws())
                .extracting(LawReference::name)
                .containsExactly("hooke_spring", "newton_motion");
        Map<String, ItemDefinition> items =
                world.items().stream()
                        .collect(
                                java.util.stream.Collectors.toMap(
                                        ItemDefinition::name, item -> item));
        assertThat(items.get("red").location()).containsExactly(-10, 5, 0);
        assertThat(items.get("red").physics("velocity").orElseThrow()).containsExactly(0, 3, 0);
        assertThat(number(items.get("red"), "mass")).isEqualTo(1000);
        assertThat(items.get("blue").location()).containsExactly(10, 5, 0);
        assertThat(items.get("blue").physics("velocity").orElseThrow()).containsExactly(0, 0, 0);
        assertThat(number(items.get("blue"), "mass")).isEqualTo(1);
        assertThat(number(items.get("spring"), "springConstant")).isEqualTo(100);
        assertThat(number(items.get("spring"), "length")).isEqualTo(20);
        assertThat(items.get("blue").actions()).extracting(Action::name).containsExactly("push");
        assertThat(world.agents().template().orElseThrow().hasPhysics()).isFalse();
    }

    private static double number(ItemDefinition item, String property) {
        double[] values = item.physics(property).orElseThrow();
        assertThat(values).hasSize(1);
        return values[0];
    }
}
