// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.Arguments;
import org.junit.jupiter.params.provider.MethodSource;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;
import java.util.function.IntFunction;
import java.util.stream.Collectors;
import java.util.stream.IntStream;
import java.util.stream.Stream;

/** Small files of MJCF that would take minutes or gigabytes to import. */
class MjcfLimitsTest {
    @TempDir private Path folder;

    static Stream<Arguments> largeFiles() {
        String ball = "<geom size=\"1\"/>";
        return Stream.of(
                Arguments.of(
                        "<worldbody><body name=\"b\">"
                                + ball
                                + times(1500, i -> "<joint name=\"" + i + "\"/>")
                                + "</body></worldbody>",
                        "the body b has 1500 joints, expected at most 6"),
                Arguments.of(
                        "<worldbody>" + times(60_000, i -> ball) + "</worldbody>",
                        "the file has more than 10000 geoms"),
                Arguments.of(
                        "<default>"
                                + times(8000, i -> "<a" + i + " b=\"1\"/>")
                                + times(8000, i -> "<default class=\"" + i + "\"/>")
                                + "</default><worldbody>"
                                + ball
                                + "</worldbody>",
                        "the default classes inherit more than 1000000 values"));
    }

    private static String times(int count, IntFunction<String> element) {
        return IntStream.range(0, count).mapToObj(element).collect(Collectors.joining());
    }

    @ParameterizedTest
    @MethodSource("largeFiles")
    @Timeout(60)
    void areRefusedWithTheReason(String content, String reason) throws Exception {
        Path file = Files.writeString(folder.resolve("r.xml"), "<mujoco>" + content + "</mujoco>");
        assertThatThrownBy(
                        () ->
                                RobotImport.read(
                                        file,
                                        new RobotImport.Options(
                                                RobotImport.Base.AUTOMATIC,
                                                true,
                                                false,
                                                false,
                                                Map.of())))
                .isInstanceOf(RobotFileException.class)
                .hasMessageContaining(reason);
    }
}
