// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.tests.Reve.Outcome;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * The launcher in a small checkout of its own. The Gradle build of this checkout stages the files
 * that the real build has made. It packs one source file into a jar of the project, so that each
 * change of the source makes another jar.
 */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class ReleasesIT {
    private static final String BUILD =
            """
            task core(type: Zip) {
                from 'reve-core/world'
                from zipTree('ROOT/build/stage/lib/reve-core-world.jar')
                duplicatesStrategy 'exclude'
                archiveName 'reve-core-world.jar'
                destinationDir file('build/stage/lib')
            }
            task natives(type: Copy) {
                from('NATIVE') {
                    include '*.so*', 'vesper', 'vesper-host', 'vesper-sandbox', 'vesper-probe', 'vesper-render', 'laws/*.so'
                }
                into 'build/native'
            }
            task stage(type: Copy, dependsOn: [core, natives]) {
                from('ROOT/build/stage/lib') { exclude 'reve-core-world.jar' }
                into 'build/stage/lib'
            }
            """;

    @TempDir private Path checkout;

    private Path source;

    @BeforeEach
    void makeCheckout() throws Exception {
        for (String folder :
                List.of(
                        "reve-core/world",
                        "reve-pe-adapter",
                        "reve-worlds",
                        "agents/java",
                        "agents/python",
                        "vesper-native",
                        "laws",
                        "law-support",
                        "gradle",
                        "scripts/release")) {
            Files.createDirectories(checkout.resolve(folder));
        }
        for (String file : List.of("reve", "scripts/release/reve", "scripts/release/java.sh")) {
            Files.copy(Project.ROOT.resolve(file), checkout.resolve(file));
        }
        Files.writeString(checkout.resolve("packages.txt"), "bash\n");
        Files.writeString(checkout.resolve("VERSION"), "1.0.0\n");
        Files.writeString(checkout.resolve("settings.gradle"), "rootProject.name = 'small'\n");
        Files.writeString(
                checkout.resolve("build.gradle"),
                BUILD.replace("ROOT", Project.ROOT.toString())
                        .replace("NATIVE", Project.NATIVE.toString()));
        source = checkout.resolve("reve-core/world/A.java");
        Files.writeString(source, "class A {}\n");
    }

    private ProcessBuilder command(String... arguments) {
        List<String> command =
                new ArrayList<>(
                        List.of("env", "-u", "REVE_BUILT", checkout.resolve("reve").toString()));
        command.addAll(List.of(arguments));
        return new ProcessBuilder(command);
    }

    private Outcome reve(String... arguments) throws Exception {
        return Reve.run(command(arguments).command());
    }

    private List<String> releases() throws IOException {
        try (Stream<Path> releases = Files.list(checkout.resolve("build/releases"))) {
            return releases.map(release -> release.getFileName().toString()).toList();
        }
    }

    private String current() throws IOException {
        return checkout.resolve("build/current").toRealPath().getFileName().toString();
    }

    @Test
    void aServerKeepsItsFilesWhileOthersAreBuiltAndOneCommandBuildsAtATime() throws Exception {
        Path errors = checkout.resolve("server.err");
        Process process =
                command(
                                "serve",
                                Project.WORLDS.resolve("spring-orbit").toString(),
                                "--port",
                                "0",
                                "--json")
                        .redirectError(errors.toFile())
                        .start();
        try (Server server = new Server(process, new Server.Events(process, errors))) {
            String port = server.port();
            String first = current();
            assertThat(releases()).containsExactly(first);
            assertThat(Files.readString(Path.of("/proc/" + process.pid() + "/cmdline")))
                    .contains("releases/" + first + "/native", "releases/" + first + "/lib");

            transientFilesBuildNothing();
            aChangeIsBuiltOnceByTwoCommands();
            String second = current();
            assertThat(second).isNotEqualTo(first);
            assertThat(releases()).containsExactlyInAnyOrder(first, second);
            try (AgentClient agent = Agents.join(Integer.parseInt(port), "ada")) {
                assertThat(agent.perceive().items()).isNotEmpty();
            }

            Files.writeString(source, "class A {}\n");
            assertThat(reve("build").code()).isZero();
            assertThat(current()).as("the sources are as at first").isEqualTo(first);
            assertThat(releases()).as("nothing runs the second").containsExactly(first);
            assertThat(process.isAlive()).isTrue();
        }
    }

    private void transientFilesBuildNothing() throws Exception {
        Files.writeString(source, Files.readString(source)); // as git does with two changes of
        // branch
        Files.writeString(checkout.resolve("reve-core/world/.A.java.swp"), "x");
        Files.writeString(checkout.resolve("reve-core/world/A.java~"), "x");
        Files.createDirectory(checkout.resolve("agents/python/reve.egg-info"));
        Files.writeString(checkout.resolve("agents/python/reve.egg-info/PKG-INFO"), "x");
        Files.writeString(checkout.resolve("laws/README.md"), "x");
        Outcome outcome = reve("--version");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(outcome.err()).doesNotContain("building");
    }

    private void aChangeIsBuiltOnceByTwoCommands() throws Exception {
        Files.writeString(source, "class A { int changed; }\n");
        Files.writeString(checkout.resolve("reve-core/world/B.java"), "class B {}\n");
        Process one = command("--version").start();
        try (BufferedReader said = one.errorReader()) {
            assertThat(said.readLine()).contains("building");
            Outcome two = reve("--version");
            assertThat(two.code()).as(two.err()).isZero();
            assertThat(two.err())
                    .contains("another ./reve is building in " + checkout)
                    .doesNotContain("reve: building");
            assertThat(two.out()).contains("REVE x Vesper");
            assertThat(one.waitFor()).as(said.lines().collect(Collectors.joining("\n"))).isZero();
        }
        Files.delete(checkout.resolve("reve-core/world/B.java"));
    }
}
