// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.nio.file.Path;

/** The places of files and folders in the checkout that is tested. */
final class Project {
    static final Path ROOT = Path.of(required("reve.root"));
    static final Path NATIVE = Path.of(required("reve.native.path"));
    static final Path WORLDS = ROOT.resolve("worlds");

    private Project() {}

    private static String required(String property) {
        String value = System.getProperty(property);
        if (value == null) {
            throw new IllegalStateException(
                    "run these tests through ./reve test, which sets -D" + property);
        }
        return value;
    }
}
