package reve.worlds;

import java.nio.file.Path;

/** What this build calls itself, and where its native part lies. */
public final class Product {
    public static final String VERSION = "0.1.0";

    /** How a checkout is called. */
    public static final String CHECKOUT_COMMAND = "./reve";

    private Product() {}

    /** What the user calls it, for messages; the launcher says. */
    public static String command() {
        return System.getProperty("reve.name", CHECKOUT_COMMAND);
    }

    /** Folder of libvesper.so, its programs, and {@code laws/}; the launcher names it. */
    public static Path nativeFolder() {
        return Path.of(System.getProperty("reve.native.path", "build/native"));
    }
}
