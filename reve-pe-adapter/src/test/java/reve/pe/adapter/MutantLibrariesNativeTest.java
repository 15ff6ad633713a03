// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.pe.NativeFiles;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.concurrent.TimeUnit;

/**
 * Law libraries in which random bytes were changed. Each is refused with a reason of one line, or
 * acts in an engine's process. The world of this test's process makes all its frames.
 */
@Tag("slow")
@Timeout(value = 60, unit = TimeUnit.MINUTES, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class MutantLibrariesNativeTest {
    /** Number of changed libraries. The fault model requires 10,000. */
    private static final int MUTANTS = Integer.getInteger("reve.test.mutants", 60);

    /** Size of the headers of an ELF file and of its segments [bytes]. */
    private static final int HEADERS = 64 + 56 * 10;

    private static final int MOST_CHANGES = 8;

    /** Returns a library with changed headers, changed bytes, a lost end, or an empty part. */
    private static byte[] mutant(byte[] whole, Random random) {
        byte[] bytes = whole.clone();
        int place = random.nextInt(bytes.length);
        switch (random.nextInt(5)) {
            case 0 -> bytes = Arrays.copyOf(bytes, place);
            case 1 ->
                    Arrays.fill(
                            bytes,
                            place,
                            bytes.length - random.nextInt(bytes.length - place),
                            (byte) 0);
            case 2, 3 -> change(bytes, HEADERS, random);
            default -> change(bytes, bytes.length, random);
        }
        return bytes;
    }

    private static void change(byte[] bytes, int end, Random random) {
        for (int changes = 1 + random.nextInt(MOST_CHANGES); changes > 0; changes--) {
            bytes[random.nextInt(end)] = (byte) random.nextInt(256);
        }
    }

    @Test
    void eachIsRefusedInOneLineOrActsWithoutHarmToOthers(@TempDir Path folder) throws IOException {
        byte[] whole = Files.readAllBytes(NativeFiles.testLaw("wind"));
        Path file = folder.resolve("mutant.so");
        Random random = new Random(1904);
        int refused = 0;
        try (HostedFixture hosted = new HostedFixture();
                HostedFixture bystander = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            bystander.world.load("newton_motion", "wind");
            expected.load("newton_motion", "wind");
            for (int i = 0; i < MUTANTS; i++) {
                Files.write(file, mutant(whole, random));
                refused += load(hosted.world, file) ? 0 : 1;
                bystander.world.run(1);
                expected.run(1);
                assertThat(bystander.world.adapter.stateHash())
                        .as("after mutant " + i)
                        .isEqualTo(expected.adapter.stateHash());
            }
            assertThat(bystander.world.events("fault")).isEmpty();
            assertThat(hosted.world.loop.frame()).isEqualTo(2L * (MUTANTS - refused));
            assertThat(hosted.world.events("fault"))
                    .allSatisfy(fault -> assertOneLine(fault.fields().get("message")));
            assertThat(refused).isBetween(MUTANTS / 10, MUTANTS * 9 / 10);
            hosted.world.load("newton_motion").run(2); // the world makes frames as before
            assertThat(hosted.world.adapter.laws().loaded()).hasSize(1);
        }
    }

    /** Loads the library for two frames; returns false if it was refused. */
    private static boolean load(AdapterFixture world, Path file) {
        Laws laws = world.adapter.laws();
        try (PreparedLibrary prepared = world.engine.prepare(file)) {
            laws.load(world.loop.frame(), prepared, Map.of());
        } catch (PhysicsException e) {
            assertOneLine(e.getMessage());
            return false;
        }
        world.run(2);
        for (int id : List.copyOf(laws.byId().keySet())) {
            laws.unload(world.loop.frame(), id);
        }
        laws.quarantined().forEach(out -> laws.release(out.sha256()));
        return true;
    }

    private static void assertOneLine(Object message) {
        assertThat(String.valueOf(message)).isNotBlank().doesNotContain("\n", "\r");
    }
}
