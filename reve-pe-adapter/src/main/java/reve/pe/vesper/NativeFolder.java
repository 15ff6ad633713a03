package reve.pe.vesper;

import java.nio.file.Files;
import java.nio.file.Path;
import org.jspecify.annotations.Nullable;

/** Where libvesper lives: the folder that the system property {@code reve.native.path} names. */
final class NativeFolder {
    private static final String PROPERTY = "reve.native.path";

    private NativeFolder() {
    }

    /** The engine's shared library; checked to be there, so that the message can say what to do. */
    static Path libvesper() {
        return libvesper(System.getProperty(PROPERTY));
    }

    static Path libvesper(@Nullable String folder) {
        String file = System.mapLibraryName("vesper");
        if (folder == null) {
            throw new IllegalStateException("system property " + PROPERTY + " is not set: start"
                + " Java with -D" + PROPERTY + "=FOLDER, the folder that holds " + file);
        }
        Path library = Path.of(folder, file).toAbsolutePath();
        if (!Files.isRegularFile(library)) {
            throw new IllegalStateException(library + " is not there: build it, or point system"
                + " property " + PROPERTY + " to the folder that holds it");
        }
        return library;
    }
}
