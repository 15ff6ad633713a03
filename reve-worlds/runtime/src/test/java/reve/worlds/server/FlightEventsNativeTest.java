// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import jdk.jfr.Recording;
import jdk.jfr.consumer.RecordedEvent;
import jdk.jfr.consumer.RecordingFile;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.List;

/** The events for Java's flight recorder. */
class FlightEventsNativeTest {
    private static final List<String> PHASES =
            List.of("intake", "act", "physics", "derive", "publish");

    @TempDir private Path folder;

    @Test
    void eachFrameAndEachLawInItHaveAnEvent() throws Exception {
        var world =
                WorldFile.parse(
                        "fall.yaml",
                        """
                        reve: 1
                        name: fall
                        laws: [gravity_field, newton_motion]
                        constants: {gravity: [0, -9.81, 0]}
                        items: [{name: stone, physical: {location: [0, 9, 0]}, physics: {mass: 1}}]
                        """
                                .getBytes(StandardCharsets.UTF_8));
        Path file = folder.resolve("run.jfr");
        try (var recording = new Recording();
                var simulation = new Simulation(world, Pacing.FAST)) {
            simulation.world().guard().claim();
            recording.enable("reve.Frame");
            recording.enable("reve.Law");
            recording.start();
            simulation.loop().run(6);
            recording.stop();
            recording.dump(file);
        }
        List<RecordedEvent> all = RecordingFile.readAllEvents(file);
        List<RecordedEvent> frames = of(all, "reve.Frame");
        assertThat(frames)
                .extracting(each -> each.getLong("frame"))
                .containsExactly(1L, 2L, 3L, 4L, 5L);
        for (RecordedEvent frame : frames) {
            assertThat(frame.getString("world")).isEqualTo("fall");
            long phases = PHASES.stream().mapToLong(frame::getLong).sum();
            assertThat(frame.getLong("physics")).isPositive();
            assertThat(phases).isLessThanOrEqualTo(frame.getLong("busy"));
        }
        List<RecordedEvent> laws = of(all, "reve.Law");
        assertThat(laws).hasSize(10);
        assertThat(laws.subList(0, 2))
                .extracting(each -> each.getString("law"))
                .containsExactly("gravity_field", "newton_motion");
        for (RecordedEvent law : laws) {
            assertThat(law.getLong("time")).isPositive();
            RecordedEvent frame = frames.get((int) law.getLong("frame") - 1);
            assertThat(law.getLong("time")).isLessThan(frame.getLong("physics"));
        }
    }

    private static List<RecordedEvent> of(List<RecordedEvent> all, String type) {
        return all.stream().filter(each -> each.getEventType().getName().equals(type)).toList();
    }
}
