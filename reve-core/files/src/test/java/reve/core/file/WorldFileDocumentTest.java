// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.world.Instrument;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** The statements of {@code docs/world-file.md} are true. */
class WorldFileDocumentTest {
    private static String page() throws IOException {
        return Files.readString(WorldFileTest.root().resolve("docs/world-file.md"));
    }

    private static List<String> blocks(String language) throws IOException {
        Matcher block =
                Pattern.compile("```" + language + "\n(.*?)```", Pattern.DOTALL).matcher(page());
        var blocks = new ArrayList<String>();
        while (block.find()) {
            blocks.add(block.group(1));
        }
        return blocks;
    }

    /** Returns the YAML block that contains a line. */
    private static String yaml(String line) throws IOException {
        return blocks("yaml").stream()
                .filter(block -> block.lines().anyMatch(line::equals))
                .findFirst()
                .orElseThrow();
    }

    @Test
    void completeExampleBuildsAWorld() throws Exception {
        WorldDescription description = WorldFileTest.parse(yaml("name: bathtub"));
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            assertThat(world.items()).hasSize(5);
            assertThat(world.find("duck").orElseThrow().physics().scalar("mass")).isEqualTo(0.08);
            assertThat(world.find("string").orElseThrow().physics().scalar("length"))
                    .isEqualTo(0.4);
        }
    }

    @Test
    void aCartHasTheWheelsThatItIncludes(@TempDir Path folder) throws Exception {
        Files.createDirectory(folder.resolve("parts"));
        Files.writeString(folder.resolve("parts/wheels.yaml"), yaml("# parts/wheels.yaml"));
        Path cart = Files.writeString(folder.resolve("cart.yaml"), yaml("# cart.yaml"));

        List<ItemDefinition> wheels = WorldFile.load(cart).items();

        assertThat(wheels)
                .hasSize(2)
                .allMatch(wheel -> wheel.shape().equals(Shape.sphere(0.3)))
                .allMatch(wheel -> wheel.physics("mass").orElseThrow()[0] == 8);
        assertThat(wheels)
                .extracting(wheel -> wheel.symbols().get("worn"))
                .containsExactly(false, true);
    }

    @Test
    void aClothIsWovenOfRepeatedItems() throws Exception {
        WorldDescription cloth = WorldFileTest.parse(yaml("# cloth.yaml"));
        try (var arena = new OffHeapArena()) {
            World world = cloth.build(arena);
            assertThat(world.table("body").rowCount()).isEqualTo(20 * 30 + 100);
            assertThat(world.table("spring").rowCount()).isEqualTo(20 * 29 + 19 * 30);
            assertThat(world.find("dust 25").orElseThrow().physics().vector("velocity")[0])
                    .isCloseTo(0, within(1e-15));
        }
    }

    @Test
    void aRoomIsFurnishedWithGroups() throws Exception {
        WorldDescription furniture = WorldFileTest.parse(yaml("# furniture.yaml"));
        assertThat(furniture.items()).hasSize(1 + 5 * 10);
        assertThat(furniture.items())
                .extracting(ItemDefinition::name)
                .contains("desk.top", "table 2.glue 1 0", "black table.leg 0 1", "table 0.vase");
        ItemDefinition leg =
                furniture.items().stream()
                        .filter(item -> item.name().equals("table 1.leg 1 0"))
                        .findFirst()
                        .orElseThrow();
        assertThat(leg.location()).containsExactly(new double[] {2.55, 0.35, 1.65}, within(1e-12));
    }

    @Test
    void theCamerasOfTheStageAreThere() throws Exception {
        WorldDescription stage = WorldFileTest.parse(yaml("name: stage"));
        assertThat(stage.cameras())
                .extracting(NamedCamera::name)
                .containsExactly("side", "watch", "chase", "rider", "flight");
        assertThat(stage.cameras().getLast().keys()).hasSize(3);
    }

    @Test
    void theInstrumentsOfTheExamplesMeasure() throws Exception {
        assertThat(instruments("name: level", "drone")).containsExactly(Instrument.Imu.class);
        assertThat(instruments("name: scales", "plate"))
                .containsExactly(Instrument.ContactForce.class);
        assertThat(instruments("name: corridor", "cart"))
                .containsExactly(Instrument.Lidar.class, Instrument.Lidar.class);
    }

    private static List<Class<?>> instruments(String world, String item) throws Exception {
        return WorldFileTest.parse(yaml(world)).items().stream()
                .filter(one -> one.name().equals(item))
                .flatMap(one -> one.sensors().stream())
                .<Class<?>>map(sensor -> sensor.instrument().orElseThrow().getClass())
                .toList();
    }

    @Test
    void mistakesGiveExactlyTheMessagesShown() throws Exception {
        byte[] mistakes = yaml("name: mistakes").getBytes(StandardCharsets.UTF_8);

        var refused =
                catchThrowableOfType(
                        WorldFileException.class, () -> WorldFile.parse("world.yaml", mistakes));

        assertThat(refused.getMessage()).isEqualTo(blocks("text").getFirst().strip());
    }

    @Test
    void tableOfStandardPropertiesIsThePrototype() throws Exception {
        String page = page();
        for (PropertyDescriptor property : WorldPrototype.standard("si-f64").properties()) {
            String row =
                    page.lines()
                            .filter(line -> line.startsWith("| `" + property.kind() + "` |"))
                            .findFirst()
                            .orElseThrow();
            String components = property.components() == 1 ? "" : " ×" + property.components();
            assertThat(row)
                    .contains(
                            property.type() == ScalarType.REF
                                    ? "`" + property.name() + "`"
                                    : "`"
                                            + property.name()
                                            + "`"
                                            + components
                                            + " ["
                                            + property.unit()
                                            + "]");
        }
    }
}
