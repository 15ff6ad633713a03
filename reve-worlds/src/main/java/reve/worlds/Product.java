// SPDX-License-Identifier: Apache-2.0
package reve.worlds;

import java.io.IOException;
import java.io.InputStream;
import java.io.UncheckedIOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;

/** What this build calls itself, and where its native part lies. */
public final class Product {
    /** How a checkout is called. */
    public static final String CHECKOUT_COMMAND = "./reve";

    private Product() {}

    /** The version number of the project: what the file VERSION said when this was built. */
    public static String version() {
        try (InputStream version = Product.class.getResourceAsStream("VERSION")) {
            return new String(version.readAllBytes(), StandardCharsets.UTF_8).strip();
        } catch (IOException cannotHappen) {
            throw new UncheckedIOException(cannotHappen);
        }
    }

    /** What the user calls it, for messages; the launcher says. */
    public static String command() {
        return System.getProperty("reve.name", CHECKOUT_COMMAND);
    }

    /** Folder of libvesper.so, its programs, and {@code laws/}; the launcher names it. */
    public static Path nativeFolder() {
        return Path.of(System.getProperty("reve.native.path", "build/native"));
    }
}
