// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import org.jspecify.annotations.Nullable;

import reve.pe.PhysicsException;
import reve.pe.Status;

import java.nio.file.Files;
import java.nio.file.Path;

/** The folder of libvesper, which the system property {@code reve.native.path} names. */
final class NativeFolder {
    private static final String PROPERTY = "reve.native.path";

    private NativeFolder() {}

    /**
     * Returns the path of the engine's shared library. Checks that the file exists, so that an
     * error message can say what to do.
     */
    static Path libvesper() {
        return libvesper(System.getProperty(PROPERTY));
    }

    static Path libvesper(@Nullable String folder) {
        String file = System.mapLibraryName("vesper");
        if (folder == null) {
            throw new IllegalStateException(
                    "system property "
                            + PROPERTY
                            + " is not set: start"
                            + " Java with -D"
                            + PROPERTY
                            + "=FOLDER, the folder that holds "
                            + file);
        }
        Path library = Path.of(folder, file).toAbsolutePath();
        if (!Files.isRegularFile(library)) {
            throw new IllegalStateException(
                    library
                            + " is not there: build it, or point system"
                            + " property "
                            + PROPERTY
                            + " to the folder that holds it");
        }
        return library;
    }

    /**
     * Returns an exception with the reason why a native library could not be opened. Java's symbol
     * lookup does not report the reason, so this method loads the library again.
     *
     * @param cause error that is reported if the library can be loaded this time
     */
    @SuppressWarnings("restricted")
    static PhysicsException refused(Path library, LinkageError cause) {
        String reason = library + ": " + cause;
        try {
            System.load(library.toString());
        } catch (UnsatisfiedLinkError unopened) {
            reason = unopened.getMessage();
        }
        return new PhysicsException(
                Status.LIBRARY_LOAD_FAILED,
                "the engine cannot be loaded: "
                        + reason
                        + " (`ldd "
                        + library
                        + "` lists the shared libraries that it needs; install"
                        + " those that are not found)");
    }
}
