// SPDX-License-Identifier: Apache-2.0
package reve.worlds;

import java.io.IOException;
import java.io.InputStream;
import java.io.UncheckedIOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;

/** The name and version of this build, and the folder of its native part. */
public final class Product {
    /** The command that starts the product from a checkout of its sources. */
    public static final String CHECKOUT_COMMAND = "./reve";

    private Product() {}

    /** Returns the project's version number: the content of the file VERSION at build time. */
    public static String version() {
        try (InputStream version = Product.class.getResourceAsStream("VERSION")) {
            return new String(version.readAllBytes(), StandardCharsets.UTF_8).strip();
        } catch (IOException cannotHappen) {
            throw new UncheckedIOException(cannotHappen);
        }
    }

    /**
     * Returns the command with which the user started the product, for messages. The launcher
     * passes it.
     */
    public static String command() {
        return System.getProperty("reve.name", CHECKOUT_COMMAND);
    }

    /**
     * Returns the folder that contains libvesper.so, the programs of the engine, and {@code laws/}.
     * The launcher passes it.
     */
    public static Path nativeFolder() {
        return Path.of(System.getProperty("reve.native.path", "build/native"));
    }
}
