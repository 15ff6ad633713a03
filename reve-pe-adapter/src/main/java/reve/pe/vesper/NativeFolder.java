package reve.pe.vesper;

import java.nio.file.Files;
import java.nio.file.Path;

/** Where libvesper lives: the folder that the system property {@code reve.native.path} names. */
final class NativeFolder {
    private static final String PROPERTY = "reve.native.path";

    private NativeFolder() {
    }

    /** The engine's shared library; checked to be there, so that the message can say what to do. */
    static Path libvesper() {
        String folder = System.getProperty(PROPERTY);
        if (folder == null) {
            throw new IllegalStateException("system property " + PROPERTY + " is not set: start"
                + " Java with -D" + PROPERTY + "=FOLDER, the folder that holds "
                + System.mapLibraryName("vesper"));
        }
        Path library = Path.of(folder, System.mapLibraryName("vesper")).toAbsolutePath();
        if (!Files.isRegularFile(library)) {
            throw new IllegalStateException(library + " is not there: build it, or point system"
                + " property " + PROPERTY + " (now '" + folder + "') to the folder that holds it");
        }
        return library;
    }
}
