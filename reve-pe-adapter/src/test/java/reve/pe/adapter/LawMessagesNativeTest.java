// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.EnumSource;

import reve.pe.NativeFiles;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.hosted.ApartRule;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;
import java.util.stream.Stream;

/**
 * The messages about a law's own mistakes that its author gets. They are the same in each place in
 * which a law can run.
 */
class LawMessagesNativeTest {
    private enum Place {
        IN_PROCESS,
        HOSTED,
        APART
    }

    /** A world with its engine at a place. */
    private record Home(AdapterFixture world, Runnable closing) implements AutoCloseable {
        static Home at(Place place) {
            if (place == Place.IN_PROCESS) {
                AdapterFixture world = HostedFixture.inProcess();
                return new Home(world, world::close);
            }
            HostedFixture hosted =
                    new HostedFixture(
                            1,
                            NativeFiles.program("vesper-host"),
                            place == Place.APART
                                    ? (file, library) -> ApartRule.Isolation.APART_WEAKLY
                                    : ApartRule.NEVER);
            return new Home(hosted.world, hosted::close);
        }

        @Override
        public void close() {
            closing.run();
        }
    }

    @ParameterizedTest
    @EnumSource
    void anExceptionOfAConstructorArrivesWithItsWhat(Place place) {
        try (Home home = Home.at(place)) {
            Laws laws = home.world.adapter.laws();
            home.world.load("newton_motion");
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> laws.load(0, "picky", Map.of()))
                    .withMessageContaining("law picky: no table of drag for 3 speeds");
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> laws.load(0, "picky_number", Map.of()))
                    .withMessageContaining(
                            "law picky: its constructor threw something that is no std::exception");
            home.world.run(2);
            assertThat(laws.loaded()).extracting(PhysicsLaw::name).containsExactly("newton_motion");
        }
    }

    /** The name of the copy matters because a stack trace names the mapping that has an address. */
    @ParameterizedTest
    @EnumSource
    void thePrivateCopyOfALawBearsItsName(Place place) {
        try (Home home = Home.at(place)) {
            home.world.load("wind");
            home.world.run(1);
            ProcessHandle self = ProcessHandle.current();
            assertThat(Stream.concat(Stream.of(self), self.descendants()))
                    .anySatisfy(
                            process ->
                                    assertThat(maps(process.pid()))
                                            .containsPattern("r-xp .*libvesper_law_wind\\.so"));
        }
    }

    private static String maps(long pid) {
        try {
            return Files.readString(Path.of("/proc", String.valueOf(pid), "maps"));
        } catch (IOException ended) {
            return "";
        }
    }
}
