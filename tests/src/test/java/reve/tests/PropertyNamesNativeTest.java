// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.pe.PropertyDescriptor;
import reve.pe.adapter.PropertyNames;
import reve.pe.vesper.VesperEngine;
import reve.worlds.server.Simulation;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.TreeMap;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/** The names that world files and laws use for the same properties. */
class PropertyNamesNativeTest {
    private static final Path PAGE = Project.ROOT.resolve("docs/world-file.md");
    private static final Pattern NAME = Pattern.compile("`(\\w+)`");
    private static final int FRAMES = 10;

    /** Returns the names in a cell of the table. */
    private static List<String> names(String cell) {
        return NAME.matcher(cell).results().map(found -> found.group(1)).toList();
    }

    @Test
    void theTableListsEveryNameThatDiffers() throws Exception {
        TreeMap<String, List<String>> listed = new TreeMap<>();
        String page = Files.readString(PAGE);
        String section = page.substring(page.indexOf("### Names of properties in laws"));
        section = section.substring(0, section.indexOf("\n## "));
        Matcher rows = Pattern.compile("(?m)^\\| (`[^|]*) \\| (`[^|]*) \\|").matcher(section);
        while (rows.find()) {
            listed.put(names(rows.group(2)).getFirst(), names(rows.group(1)));
        }
        var different =
                VesperEngine.standardPrototype("si-f64").properties().stream()
                        .filter(property -> !columns(property).equals(List.of(property.name())))
                        .collect(
                                Collectors.toMap(
                                        PropertyDescriptor::name,
                                        PropertyNamesNativeTest::columns));
        assertThat(listed).isEqualTo(new TreeMap<>(different));
    }

    private static List<String> columns(PropertyDescriptor property) {
        return PropertyNames.columns(property.kind(), property.name());
    }

    /** Returns the state after some frames with a law that reads the constant under a name. */
    private static long hash(Path folder, String name) throws Exception {
        String text =
                """
                reve: 1
                name: names
                laws:
                  - newton_motion
                  - text: |
                      law pull "Pulls along springs."
                        each spring from a to b, r apart:
                          attraction = NAME (r - length)
                items:
                  - {name: hook, physics: {mass: 0 kg}}
                  - {name: ball, physics: {mass: 1 kg}, physical: {location: [3, 0, 0]}}
                  - {name: band, kind: spring, physics: {end1: hook, end2: ball, length: 1 m, springConstant: 6 N/m}}
                """;
        Path file = Files.writeString(folder.resolve("world.yaml"), text.replace("NAME", name));
        try (Simulation world = new Simulation(WorldFile.load(file), Pacing.FAST)) {
            world.loop().run(FRAMES);
            assertThat(world.world().find("ball").orElseThrow().physical().location()[0])
                    .as("the spring pulls the ball")
                    .isLessThan(3);
            return world.physics().stateHash();
        }
    }

    @Test
    void aTextReadsTheConstantOfASpringUnderEachName(@TempDir Path folder) throws Exception {
        assertThat(hash(folder, "springConstant"))
                .isEqualTo(hash(folder, "hookeConstant"))
                .isEqualTo(hash(folder, "stiffness"));
    }
}
