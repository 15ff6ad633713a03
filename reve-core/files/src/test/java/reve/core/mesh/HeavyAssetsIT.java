// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.TimeUnit;

/** The cost of the heaviest assets, in a JVM of 512 MiB. */
@Tag("slow")
class HeavyAssetsIT {

    private static final boolean ALL = Boolean.getBoolean("reve.test.assets.all");
    private static final int MAX_MILLISECONDS = 5000;
    private static final List<String> QUICK =
            List.of(
                    "obj-groups-times-faces",
                    "mtl-options",
                    "links-to-one-obj",
                    "gltf-lists",
                    "gltf-400-buffers",
                    "gltf-2000-images",
                    "dae-numbers",
                    "dae-attributes",
                    "jpeg-scans");

    @TempDir private Path folder;

    /** With {@code -Dreve.test.assets.all=true}: all cases. */
    @Test
    void eachIsReadOrRefusedWithinFiveSecondsAndHalfAGibibyte() throws Exception {
        List<String> names = ALL ? List.copyOf(HeavyAssets.names()) : QUICK;
        Path errors = folder.resolve("errors");
        List<String> command =
                new ArrayList<>(
                        List.of(
                                System.getProperty("java.home") + "/bin/java",
                                "-Xmx512m",
                                "-XX:+UseSerialGC",
                                "-cp",
                                System.getProperty("java.class.path"),
                                HeavyAssets.class.getName(),
                                folder.toString()));
        command.addAll(names);
        Path output = folder.resolve("output");
        Process reading =
                new ProcessBuilder(command)
                        .redirectOutput(output.toFile())
                        .redirectError(errors.toFile())
                        .start();
        boolean ended = reading.waitFor(30, TimeUnit.MINUTES);
        reading.destroyForcibly();
        List<String> lines = Files.readAllLines(output);
        assertThat(ended).as("%s", lines).isTrue();
        assertThat(reading.exitValue()).as(Files.readString(errors)).isZero();
        assertThat(lines)
                .hasSameSizeAs(names)
                .allSatisfy(
                        line -> {
                            String[] parts = line.split("\t");
                            assertThat(Long.parseLong(parts[1]))
                                    .as(line)
                                    .isLessThan(MAX_MILLISECONDS);
                            assertThat(parts[2])
                                    .matches("read|[\\w.]+: [^\n]+")
                                    .doesNotContainPattern(
                                            "(java|tools|com)\\.\\w|Exception|Error|null");
                        });
        if (ALL) {
            lines.forEach(System.out::println);
        }
    }
}
