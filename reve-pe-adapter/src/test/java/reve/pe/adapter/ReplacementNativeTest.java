// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.offset;

import org.junit.jupiter.api.Test;

import reve.pe.NativeFiles;
import reve.pe.PreparedLibrary;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * Many replacements of a law in the engine's process. The environment variable {@code
 * REVE_REPLACEMENTS} sets their number.
 */
class ReplacementNativeTest {
    private static final int REPLACEMENTS =
            Integer.parseInt(System.getenv().getOrDefault("REVE_REPLACEMENTS", "60"));

    /** Number of frames after which a test law that does harm acts in its first frame. */
    private static final int HARMLESS_FRAMES = 60;

    /** Number of replacements after which caches are full. */
    private static final int SETTLED = 10;

    @Test
    void noFrameHasNeitherOrBothVersionsAndNothingIsLeft() throws IOException {
        try (HostedFixture hosted = new HostedFixture()) {
            AdapterFixture world = hosted.world;
            world.load("newton_motion", "wind", "greets").run(2);
            Laws laws = world.adapter.laws();
            int wind = laws.byId().keySet().stream().skip(1).findFirst().orElseThrow();
            long ours = 0;
            long theirs = 0;
            Map<Long, Long> hosts = Map.of();
            for (int i = 0; i < REPLACEMENTS; i++) {
                int newtons = i % 2 == 0 ? 2 : 1;
                String name = newtons == 2 ? "strong_wind" : "wind";
                try (PreparedLibrary next = world.engine.prepare(NativeFiles.testLaw(name))) {
                    laws.replace(
                            world.loop.frame(),
                            wind,
                            next,
                            Map.of(),
                            NativeFiles.testLaw(name),
                            made -> {});
                }
                double[] before = world.velocity("b0");
                world.run(1);
                double gained = world.velocity("b0")[0] - before[0];
                assertThat(gained * 60).as("replacement %d", i).isCloseTo(newtons, offset(1e-9));
                if (i == SETTLED) {
                    ours = descriptors(ProcessHandle.current().pid());
                    hosts = hosts();
                }
            }
            assertThat(laws.libraries())
                    .extracting(LawLibrary::name)
                    .containsExactly("newton_motion", "wind", "greets");
            assertThat(descriptors(ProcessHandle.current().pid())).isLessThanOrEqualTo(ours + 2);
            for (Map.Entry<Long, Long> host : hosts().entrySet()) {
                theirs = hosts.getOrDefault(host.getKey(), Long.MAX_VALUE - 2);
                assertThat(host.getValue()).isLessThanOrEqualTo(theirs + 2);
            }
            assertThat(world.events("fault")).isEmpty();
        }
    }

    /** The process of the new version is lost. The next process begins with the old version. */
    @Test
    void aVersionThatEndsTheProcessIsRolledBackToTheBit() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture clean = HostedFixture.inProcess()) {
            AdapterFixture world = hosted.world;
            for (AdapterFixture each : List.of(world, clean)) {
                each.load("newton_motion", "wind", "greets").run(HARMLESS_FRAMES);
            }
            Laws laws = world.adapter.laws();
            laws.keepPreviousFor(HARMLESS_FRAMES);
            int wind = laws.byId().keySet().stream().skip(1).findFirst().orElseThrow();
            Path bad = NativeFiles.testLaw("hostile_segfault");
            List<LawChange> changes = new ArrayList<>();
            laws.addListener(changes::add);
            try (PreparedLibrary next = world.engine.prepare(bad)) {
                laws.replace(world.loop.frame(), wind, next, Map.of(), bad, made -> {});
            }
            for (int frame = 0; frame < SETTLED; frame++) {
                world.run(1);
                clean.run(1);
                assertThat(world.bytes()).as("frame %d", frame).isEqualTo(clean.bytes());
            }
            assertThat(changes)
                    .extracting(change -> (Object) change.getClass())
                    .containsExactly(LawChange.Replaced.class, LawChange.RolledBack.class);
            assertThat(laws.libraries())
                    .extracting(LawLibrary::name)
                    .containsExactly("newton_motion", "wind", "greets");
            assertThat(world.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("status", "LAW_CRASHED")
                                            .containsEntry("library", "hostile")
                                            .containsEntry(
                                                    "rolledBackTo",
                                                    laws.byId().get(wind).sha256()));
        }
    }

    /** Returns the number of open descriptors of each engine process. */
    private static Map<Long, Long> hosts() {
        List<ProcessHandle> hosts =
                ProcessHandle.current()
                        .children()
                        .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                        .toList();
        return hosts.stream()
                .collect(Collectors.toMap(ProcessHandle::pid, host -> descriptors(host.pid())));
    }

    private static long descriptors(long process) {
        try (Stream<Path> open = Files.list(Path.of("/proc/" + process + "/fd"))) {
            return open.count();
        } catch (IOException e) {
            return 0; // it has just ended
        }
    }
}
