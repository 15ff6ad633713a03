package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.ArrayList;
import java.util.List;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;
import reve.tests.Reve.Outcome;

/**
 * An installed folder runs without the checkout, without tools for building, and read-only, as
 * another user if the tests run as root.
 */
@Timeout(value = 300, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class InstallIT {
    private static final String NOBODY = "65534";

    @TempDir
    private Path folder;

    private Path installed;
    private Path home;

    @Test
    void anInstalledFolderRunsReadOnlyForAnotherUserWithoutTheCheckout() throws Exception {
        Files.setPosixFilePermissions(folder, PosixFilePermissions.fromString("rwxr-xr-x"));
        installed = folder.resolve("reve");
        home = Files.createDirectory(folder.resolve("home"));
        Files.setPosixFilePermissions(home, PosixFilePermissions.fromString("rwxrwxrwx"));
        Outcome install = Reve.launch("install", installed.toString());
        assertThat(install.code()).as(install.err()).isZero();
        sh("chmod -R a-w " + installed + " && mkdir " + folder + "/bin && cp "
                + "$(command -v bash) $(command -v readlink) " + folder + "/bin");

        String world = installed.resolve("worlds/spring-orbit").toString();
        Outcome run = run("run", world, "--seconds", "1");
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(run.out()).contains("spring-orbit: 60 frames", "state hash");
        assertThat(run("check", world).code()).isZero();
        Path picture = home.resolve("orbit.png");
        assertThat(run("snapshot", world, "--out", picture.toString()).code()).isZero();
        assertThat(picture).isNotEmptyFile();
        serve(world);
        refusesWhatNeedsACheckout();
        again();
    }

    /** Nothing that the server has opened or was started with lies in the checkout. */
    private void serve(String world) throws Exception {
        Path errors = folder.resolve("server.err");
        Process process = new ProcessBuilder(command("serve", world, "--port", "0", "--json",
                "--store", home.resolve("my.db").toString()))
                .redirectError(errors.toFile()).start();
        try (Server server = new Server(process,
                new Server.Events(process.inputReader(), errors))) {
            String pid = server.events().await("ready", event -> true).path("pid").asString();
            assertThat(Files.readString(Path.of("/proc", pid, "cmdline")))
                    .contains("-Dreve.root=" + installed)
                    .doesNotContain(Project.ROOT.toString());
            assertThat(Files.readString(Path.of("/proc", pid, "maps")))
                    .contains(installed + "/native/libvesper.so")
                    .doesNotContain(Project.ROOT + "/");
            process.toHandle().destroy();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }
    }

    private void refusesWhatNeedsACheckout() throws Exception {
        for (String command : List.of("build", "test", "install")) {
            Outcome refused = run(command);
            assertThat(refused.code()).isEqualTo(2);
            assertThat(refused.err()).contains(command + " needs the sources and compilers");
        }
        assertThat(run("--help").out()).startsWith("Usage: reve ").contains("doctor")
                .doesNotContain("install ");
    }

    private void again() throws Exception {
        Outcome again = Reve.launch("install", installed.toString());
        assertThat(again.code()).isEqualTo(2);
        assertThat(again.err()).contains("is there already and may be in use");
        Outcome doctor = Reve.run(List.of(installed.resolve("bin/reve").toString(), "doctor"));
        assertThat(doctor.code()).as(doctor.err()).isZero();
        assertThat(doctor.out()).contains("folder: " + installed, "nothing is missing");
    }

    private Outcome run(String... arguments) throws Exception {
        return Reve.run(command(arguments));
    }

    /** The installed command as its user: no tools but two, a home of one's own. */
    private List<String> command(String... arguments) throws IOException {
        List<String> command = new ArrayList<>();
        if ((int) Files.getAttribute(folder, "unix:uid") == 0) {
            command.addAll(List.of("setpriv", "--reuid=" + NOBODY, "--regid=" + NOBODY,
                    "--clear-groups"));
        }
        command.addAll(List.of("env", "-i", "--default-signal=INT", "-C", home.toString(),
                "PATH=" + folder.resolve("bin"), "HOME=" + home,
                "REVE_JAVA_HOME=" + System.getProperty("java.home"),
                installed.resolve("bin/reve").toString()));
        command.addAll(List.of(arguments));
        return command;
    }

    private static void sh(String script) throws Exception {
        Outcome outcome = Reve.run(List.of("bash", "-euc", script));
        assertThat(outcome.code()).as(outcome.err()).isZero();
    }
}
