// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.pe.PreparedLibrary;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.Set;

/**
 * Laws whose sum of forces depends on their order, because of rounding: (1e16 + 1) - 1e16 is 0, and
 * (1e16 - 1e16) + 1 is 1.
 */
class LawOrderNativeTest {
    /** Number of random orders. The fault model requires 100. */
    private static final int ORDERS = Integer.getInteger("reve.test.law.orders", 20);

    private static final int FRAMES = 3;
    private static final Map<String, String> FORCES =
            Map.of("a", "1e16", "b", "1", "c", "-1e16", "d", "3", "e", "0.1");

    private static byte[] text(String name) {
        return "law %s\n  each body: force += %s N (1, 0, 0)\n"
                .formatted(name, FORCES.get(name))
                .getBytes(StandardCharsets.UTF_8);
    }

    /** Returns the names of the laws in a random order. */
    private static List<String> shuffled(Random random) {
        List<String> names = new ArrayList<>(FORCES.keySet());
        Collections.sort(names);
        Collections.shuffle(names, random);
        return names;
    }

    @Test
    void aJournalRepeatsEachOrderOfLoadingToTheBit() {
        Random random = new Random(1911);
        Set<Long> hashes = new HashSet<>();
        for (int order = 0; order < ORDERS; order++) {
            try (AdapterFixture world = HostedFixture.inProcess().load("newton_motion");
                    AdapterFixture replayed = HostedFixture.inProcess().load("newton_motion")) {
                List<LawChange> changes = new ArrayList<>();
                world.adapter.laws().addListener(changes::add);
                for (String name : shuffled(random)) {
                    try (PreparedLibrary law =
                            world.engine.prepareText(name + ".law", text(name))) {
                        world.adapter.laws().load(0, law, Map.of());
                    }
                }
                world.run(FRAMES);
                changes.forEach(change -> replayed.adapter.laws().apply(0, change));
                replayed.run(FRAMES);
                assertThat(replayed.adapter.stateHash())
                        .as("order " + order)
                        .isEqualTo(world.adapter.stateHash());
                hashes.add(world.adapter.stateHash());
            }
        }
        assertThat(hashes).as("the order matters").hasSizeGreaterThan(1);
    }

    /** The order of the files' names decides, not the order in which they were written. */
    @Test
    void filesThatAppearTogetherAreLoadedInTheOrderOfTheirNames(@TempDir Path parent)
            throws IOException {
        Random random = new Random(1911);
        Set<Long> hashes = new HashSet<>();
        for (int order = 0; order < ORDERS; order++) {
            Path folder = Files.createDirectory(parent.resolve("laws" + order));
            try (AdapterFixture world = HostedFixture.inProcess().load("newton_motion");
                    LawFolder laws =
                            new LawFolder(
                                    LawFolder.ORIGIN,
                                    folder,
                                    world.engine,
                                    world.adapter.laws(),
                                    world.commands,
                                    (library, file) -> FolderParameters.NONE)) {
                for (String name : shuffled(random)) {
                    Files.write(folder.resolve(name + ".law"), text(name));
                }
                laws.look();
                laws.look();
                world.run(FRAMES);
                assertThat(world.adapter.laws().libraries())
                        .extracting(LawLibrary::name)
                        .containsExactly("newton_motion", "a", "b", "c", "d", "e");
                hashes.add(world.adapter.stateHash());
            }
        }
        assertThat(hashes).hasSize(1);
    }
}
