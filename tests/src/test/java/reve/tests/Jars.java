// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import java.util.Set;
import java.util.TreeSet;
import java.util.jar.Attributes;
import java.util.jar.JarFile;
import java.util.stream.Collectors;

/** The jars of the project's Gradle projects that ship. */
final class Jars {
    static final Path FOLDER = Project.ROOT.resolve("build/stage/lib");

    /** Their names without the ending. */
    static final List<String> NAMES =
            List.of(
                    "reve-core-world",
                    "reve-core-files",
                    "reve-core-agents",
                    "reve-pe-adapter",
                    "reve-worlds-runtime",
                    "reve-worlds-web",
                    "reve-worlds-cluster",
                    "reve-worlds-app",
                    "agents-java");

    private Jars() {}

    private static JarFile open(String name) throws IOException {
        return new JarFile(FOLDER.resolve(name + ".jar").toFile());
    }

    /** Returns the files that a jar's manifest adds to the class path. */
    static Set<String> broughtBy(String name) throws IOException {
        try (JarFile jar = open(name)) {
            String files =
                    jar.getManifest().getMainAttributes().getValue(Attributes.Name.CLASS_PATH);
            return new TreeSet<>(List.of(files.split(" ")));
        }
    }

    /** Returns the folders of a jar that contain classes. */
    static Set<String> packages(String name) throws IOException {
        try (JarFile jar = open(name)) {
            return jar.stream()
                    .filter(entry -> entry.getName().endsWith(".class"))
                    .map(entry -> entry.getName().substring(0, entry.getName().lastIndexOf('/')))
                    .collect(Collectors.toCollection(TreeSet::new));
        }
    }
}
