// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/**
 * A world of one moving stone, and the folder of laws that its servers watch. Test laws that do
 * harm (reve-pe-adapter/src/test/native) are harmless in the first {@link #HARMLESS_STEPS} of its
 * steps.
 *
 * @param file the world file
 * @param laws the folder of laws
 */
record StoneWorld(Path file, Path laws) {
    /** Number of steps, which is HOSTILE_STEP of the test laws. */
    static final long HARMLESS_STEPS = 50;

    private static final String TEXT =
            """
            reve: 1
            name: stones
            laws: [newton_motion]
            agents: {body: {physical: {location: [0, 0, 0]}}}
            items:
              - name: stone
                physical: {location: [1, 0, 0]}
                physics: {mass: 1 kg, velocity: [1, 0, 0]}
            """;

    /** Writes the world file {@code stones.yaml} and the folder {@code laws} into a folder. */
    static StoneWorld in(Path folder) throws IOException {
        return new StoneWorld(
                Files.writeString(folder.resolve("stones.yaml"), TEXT),
                Files.createDirectory(folder.resolve("laws")));
    }

    Server serve(String... options) throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "serve",
                                file.toString(),
                                "--port",
                                "0",
                                "--json",
                                "--laws",
                                laws.toString()));
        arguments.addAll(List.of(options));
        return Server.start(file.getParent(), arguments.toArray(String[]::new));
    }
}
