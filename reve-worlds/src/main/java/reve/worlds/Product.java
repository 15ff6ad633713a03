package reve.worlds;

import java.nio.file.Path;

/** What this build calls itself, and where its native part lies. */
public final class Product {
    public static final String VERSION = "0.1.0";

    private Product() {}

    /** Folder of libvesper.so, its programs, and {@code laws/}; the launcher names it. */
    public static Path nativeFolder() {
        return Path.of(System.getProperty("reve.native.path", "build/native"));
    }
}
