// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.nio.file.Path;
import java.util.List;

/** The places of the native files that the tests load. */
public final class NativeFiles {
    private static final Path FOLDER = Path.of(System.getProperty("reve.native.path"));

    private NativeFiles() {}

    /** The project's laws, and the test laws of this project. */
    public static List<Path> lawPath() {
        return List.of(FOLDER.resolve("laws"), FOLDER.resolve("adapter-test-laws"));
    }

    /** The file of a law library of {@code src/test/native}. */
    public static Path testLaw(String name) {
        return FOLDER.resolve("adapter-test-laws").resolve("libvesper_law_" + name + ".so");
    }
}
