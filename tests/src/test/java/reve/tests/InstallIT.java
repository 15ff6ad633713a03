// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * An installed folder runs without the checkout and without tools for building. It is read-only. If
 * the tests run as root, another user runs it.
 */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class InstallIT {
    private static final String NOBODY = "65534";

    @TempDir private Path folder;

    private final Document page = Document.read(Project.ROOT.resolve("docs/operations.md"));
    private Path installed;
    private Path home;
    private Shell shell;

    InstallIT() throws IOException {}

    @Test
    void anInstalledFolderRunsReadOnlyForAnotherUserWithoutTheCheckout() throws Exception {
        Files.setPosixFilePermissions(folder, PosixFilePermissions.fromString("rwxr-xr-x"));
        installed = folder.resolve("reve-1");
        shell = new Shell(folder);
        home = Files.createDirectory(folder.resolve("home"));
        Files.setPosixFilePermissions(home, PosixFilePermissions.fromString("rwxrwxrwx"));
        assertThat(shell.run(page.titled("install.sh").text()))
                .contains("folder: " + installed, "nothing is missing");
        shell.run(
                "chmod -R a-w "
                        + installed
                        + " && mkdir "
                        + folder
                        + "/bin && cp "
                        + "$(command -v bash) $(command -v readlink) "
                        + folder
                        + "/bin");

        String world = installed.resolve("worlds/spring-orbit").toString();
        Outcome run = run("run", world, "--seconds", "1");
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(run.out()).contains("spring-orbit: 60 frames", "state hash");
        assertThat(run("check", world).code()).isZero();
        Path picture = home.resolve("orbit.png");
        assertThat(run("picture", world, "--out", picture.toString()).code()).isZero();
        assertThat(picture).isNotEmptyFile();
        String hash = serve(world);
        new Shell(home).run(page.titled("backup.sh").text() + "chmod -R a+rwX backup\n");
        Outcome restored =
                run(
                        "serve",
                        world,
                        "--port",
                        "0",
                        "--json",
                        "--seconds",
                        "0.1",
                        "--store",
                        home.resolve("backup/world.db").toString());
        assertThat(restored.out()).as(restored.err()).contains("\"stateHash\":\"" + hash + "\"");
        demonstratesInTheWorkingFolder();
        refusesWhatNeedsACheckout();
        namesItselfAsItIsCalled();
        linksOfItsPagesLeadSomewhere();
        refusesToOverwrite();
        assertThat(Files.readString(installed.resolve("reve.service")))
                .contains("ExecStart=" + installed + "/bin/reve serve " + installed + "/worlds/")
                .contains("OOMPolicy=continue")
                .doesNotContain("@HOME@");
        namesWhatIsMissing();
    }

    /**
     * Runs a server, which opens and starts no file of the checkout.
     *
     * @return the hash of its last state
     */
    private String serve(String world) throws Exception {
        Path errors = folder.resolve("server.err");
        Process process =
                new ProcessBuilder(
                                command(
                                        "serve",
                                        world,
                                        "--port",
                                        "0",
                                        "--json",
                                        "--store",
                                        home.resolve("world.db").toString()))
                        .redirectError(errors.toFile())
                        .start();
        try (Server server = new Server(process, new Server.Events(process, errors))) {
            String pid = server.events().await("ready", event -> true).path("pid").asString();
            assertThat(Files.readString(Path.of("/proc", pid, "cmdline")))
                    .contains("-Dreve.root=" + installed)
                    .doesNotContain(Project.ROOT.toString());
            assertThat(Files.readString(Path.of("/proc", pid, "maps")))
                    .contains(installed + "/native/libvesper.so")
                    .doesNotContain(Project.ROOT + "/");
            process.toHandle().destroy();
            String hash = server.events().await("end", event -> true).path("stateHash").asString();
            assertThat(server.exitCode()).isZero();
            return hash;
        }
    }

    private void demonstratesInTheWorkingFolder() throws Exception {
        Outcome withoutPython = run("demo");
        assertThat(withoutPython.code()).isEqualTo(1);
        assertThat(withoutPython.err()).contains("the Python agent needs the program python3");
        shell.run("ln -s /usr/bin/python3 bin/python3");
        Outcome demo = run("demo");
        assertThat(demo.code()).as(demo.err()).isZero();
        assertThat(home.resolve("reve-demo")).isDirectoryContaining("glob:**.png");
    }

    private void refusesWhatNeedsACheckout() throws Exception {
        for (String command : List.of("build", "test", "format", "docs", "install")) {
            Outcome refused = run(command);
            assertThat(refused.code()).isEqualTo(2);
            assertThat(refused.err()).contains(command + " needs the sources and compilers");
        }
        assertThat(run("--help").out())
                .startsWith("Usage: reve ")
                .contains("doctor")
                .doesNotContain("install ");
    }

    private void namesItselfAsItIsCalled() throws Exception {
        Outcome refused =
                run(
                        "serve",
                        installed.resolve("worlds/spring-orbit").toString(),
                        "--listen",
                        "0.0.0.0");
        assertThat(refused.err()).contains("\n    reve token new NAME").doesNotContain("./reve");
    }

    private void linksOfItsPagesLeadSomewhere() throws IOException {
        Pattern link = Pattern.compile("]\\(([^)#:\\s]+)[)#]");
        List<Path> pages = new ArrayList<>(List.of(installed.resolve("README.md")));
        for (String folderOfPages : List.of("docs", "worlds")) {
            try (Stream<Path> files = Files.walk(installed.resolve(folderOfPages))) {
                files.filter(file -> file.toString().endsWith(".md")).forEach(pages::add);
            }
        }
        for (Path page : pages) {
            assertThat(
                            link.matcher(Files.readString(page))
                                    .results()
                                    .map(found -> page.resolveSibling(found.group(1))))
                    .as(page.toString())
                    .allMatch(Files::exists);
        }
    }

    private void refusesToOverwrite() throws Exception {
        Outcome again = Reve.launch("install", installed.toString());
        assertThat(again.code()).isEqualTo(2);
        assertThat(again.err()).contains("is there already and may be in use");
    }

    /** Checks the message about an engine that needs a library which the machine does not have. */
    private void namesWhatIsMissing() throws Exception {
        shell.run(
                """
                chmod -R u+w reve-1
                cd reve-1/native
                echo 'int f(void) { return 1; }' > f.c
                gcc -shared -fPIC -Wl,-soname,libtbb.so.12 f.c -o libtbb.so.12
                echo 'int f(void); int g(void) { return f(); }' > g.c
                rm libvesper.so
                gcc -shared -fPIC g.c -L. -l:libtbb.so.12 -Wl,-soname,libvesper.so -o libvesper.so
                mv libtbb.so.12 libgone.so
                sed -i s/libtbb.so.12/libtbb.so.xx/ libvesper.so
                """);
        Outcome check = run("check", installed.resolve("worlds/spring-orbit").toString());
        assertThat(check.code()).isEqualTo(4);
        assertThat(check.err())
                .contains("the engine cannot be loaded", "libvesper.so", "libtbb.so.xx")
                .doesNotContain("\tat ");
        Outcome doctor = Reve.run(List.of(installed.resolve("bin/reve").toString(), "doctor"));
        assertThat(doctor.code()).isEqualTo(1);
        assertThat(doctor.err()).contains("native/libvesper.so needs libtbb.so.xx");
    }

    private Outcome run(String... arguments) throws Exception {
        return Reve.run(command(arguments));
    }

    /** Returns the installed command for its user, who has only two tools and a separate home. */
    private List<String> command(String... arguments) throws IOException {
        List<String> command = new ArrayList<>();
        if ((int) Files.getAttribute(folder, "unix:uid") == 0) {
            command.addAll(
                    List.of("setpriv", "--reuid=" + NOBODY, "--regid=" + NOBODY, "--clear-groups"));
        }
        command.addAll(
                List.of(
                        "env",
                        "-i",
                        "--default-signal=INT",
                        "-C",
                        home.toString(),
                        "PATH=" + folder.resolve("bin"),
                        "HOME=" + home,
                        "REVE_JAVA_HOME=" + System.getProperty("java.home"),
                        installed.resolve("bin/reve").toString()));
        command.addAll(List.of(arguments));
        return command;
    }
}
