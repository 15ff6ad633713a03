// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.fail;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;

import reve.core.world.OffHeapArena;
import reve.core.world.World;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Random;

/**
 * Worlds of the project in which keys and values of all types are at wrong places. Each world is
 * refused with a place and a reason, or it is valid and can be built. About 94 % are refused. A
 * check that refuses more would refuse valid worlds. The seed is fixed, so that the bound can be
 * close to this number. {@code -Dreve.test.seed=N} gives other worlds.
 */
@Tag("slow")
class DamagedWorldsTest {
    private static final int MUTANTS = Integer.getInteger("reve.world.mutants", 300);

    /**
     * At least one mutant in that many must be a valid world. The test proves nothing if only one
     * of the two answers occurs.
     */
    private static final int LEAST_BUILT = 30;

    /** Larger files would test nothing new and would take more time. */
    private static final int MAX_LENGTH = 6000;

    @Test
    void damageIsToldWithItsPlaceOrDoesNotKeepAWorldFromBeingBuilt() throws IOException {
        long seed = Long.getLong("reve.test.seed", 1);
        var random = new Random(seed);
        List<Object> worlds = new ArrayList<>();
        for (Object world : WorldTrees.worlds().values()) {
            if (WorldTrees.json(world).length() < MAX_LENGTH && isRight(world)) {
                worlds.add(world);
            }
        }
        assertThat(worlds)
                .as("small worlds of the project that need no files")
                .hasSizeGreaterThan(4);
        int refused = 0;
        for (int i = 0; i < MUTANTS; i++) {
            Object mutant = WorldTrees.copy(worlds.get(random.nextInt(worlds.size())));
            int changes = 1 + Math.min(random.nextInt(3), random.nextInt(3)); // mostly 1, at most 3
            for (; changes > 0; changes--) {
                WorldTrees.mutate(mutant, random);
            }
            String text = text(mutant);
            try {
                refused += isRefusedWithPlaces(text) ? 1 : 0;
            } catch (RuntimeException | Error crash) {
                fail("seed " + seed + ", mutant " + i + "\n" + text, crash);
            }
        }
        assertThat(refused).as("seed %d", seed).isGreaterThan(MUTANTS / 4);
        assertThat(MUTANTS - refused)
                .as("mutants that were built, seed %d", seed)
                .isGreaterThan(MUTANTS / LEAST_BUILT);
    }

    private static boolean isRight(Object world) {
        try {
            WorldFile.parse("w", text(world).getBytes(StandardCharsets.UTF_8));
            return true;
        } catch (WorldFileException needsFiles) {
            return false;
        }
    }

    private static boolean isRefusedWithPlaces(String text) {
        int lines = (int) text.lines().count();
        try (var arena = new OffHeapArena()) {
            World built = WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)).build(arena);
            assertThat(built.items()).isNotEmpty();
            return false;
        } catch (WorldFileException refused) {
            assertThat(refused.problems())
                    .isNotEmpty()
                    .isSorted()
                    .hasSizeLessThanOrEqualTo(Problems.MAX_REPORTED + 1);
            for (Problem problem : refused.problems()) {
                assertThat(problem.line()).as("%s", problem).isBetween(1, lines);
                String line = text.lines().skip(problem.line() - 1).findFirst().orElseThrow();
                assertThat(problem.column()).as("%s", problem).isBetween(1, line.length() + 1);
                assertThat(problem.message())
                        .isNotBlank()
                        .hasSizeLessThan(1500)
                        .doesNotContainPattern("\\p{Cc}");
            }
            return true;
        }
    }

    /** A line for each key of the world, and for each item. */
    private static String text(Object world) {
        var text = new StringBuilder();
        ((Map<?, ?>) world)
                .forEach(
                        (key, value) -> {
                            text.append(WorldTrees.json(key)).append(':');
                            if (value instanceof List<?> list && !list.isEmpty()) {
                                list.forEach(
                                        element ->
                                                text.append("\n  - ")
                                                        .append(WorldTrees.json(element)));
                                text.append('\n');
                            } else {
                                text.append(' ').append(WorldTrees.json(value)).append('\n');
                            }
                        });
        return text.toString();
    }
}
