// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import reve.worlds.cli.Main;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.FutureTask;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/**
 * The {@code ./reve} command line. A command runs in the JVM of the tests, because the start of
 * another JVM takes more processor time than most commands. It runs as a process of the current
 * release where the process matters: its environment, its limits, its launcher, how it ends.
 */
final class Reve {
    private static final long PATIENCE_SECONDS = 600;

    /**
     * The launcher's message while the user waits for a slow machine. It does not matter for the
     * result.
     */
    private static final Pattern PATIENCE =
            Pattern.compile("^reading .* \\.\\.\\.\\R", Pattern.MULTILINE);

    /** A line about the progress of a command, such as {@code frame 12, 40 %, about 3 s left}. */
    private static final Pattern PROGRESS =
            Pattern.compile("(frame \\d+( of \\d+ \\(\\d+ %\\))?, \\d|\\d+ of \\d+ runs, ).*");

    /**
     * The result of a finished command.
     *
     * @param err without the launcher's message about waiting
     */
    record Outcome(int code, String out, String err) {
        /**
         * Returns standard error without the lines about progress, which a command prints if it
         * takes longer than two seconds.
         */
        String messages() {
            return err.lines()
                    .filter(line -> !PROGRESS.matcher(line).matches())
                    .collect(Collectors.joining("\n"));
        }
    }

    private Reve() {}

    /**
     * Runs a command to its end in this JVM. Must not be called by two threads at once, because the
     * standard output of the JVM belongs to the command meanwhile.
     */
    static Outcome run(String... words) throws InterruptedException {
        String[] arguments = patient(words);
        var out = new ByteArrayOutputStream();
        var err = new ByteArrayOutputStream();
        var command = new FutureTask<>(() -> Main.run(arguments));
        PrintStream usualOut = System.out;
        PrintStream usualErr = System.err;
        try {
            System.setOut(new PrintStream(out, true, StandardCharsets.UTF_8));
            System.setErr(new PrintStream(err, true, StandardCharsets.UTF_8));
            Thread.ofPlatform().name("reve").daemon().start(command);
            int code = command.get(PATIENCE_SECONDS, TimeUnit.SECONDS);
            return new Outcome(code, text(out), withoutPatience(text(err)));
        } catch (ExecutionException failed) {
            throw new AssertionError(
                    List.of(arguments) + " failed without an exit code", failed.getCause());
        } catch (TimeoutException late) {
            throw new AssertionError(
                    List.of(arguments) + " did not end within " + PATIENCE_SECONDS + " s", late);
        } finally {
            System.setOut(usualOut);
            System.setErr(usualErr);
        }
    }

    private static String text(ByteArrayOutputStream written) {
        return written.toString(StandardCharsets.UTF_8);
    }

    private static String withoutPatience(CharSequence err) {
        return PATIENCE.matcher(err).replaceAll("");
    }

    /** Runs a command to its end as a process of the current release. */
    static Outcome runAsProcess(String... arguments) throws IOException, InterruptedException {
        return run(command(arguments));
    }

    /**
     * Runs a command to its end by the shell script of that name, which handles some commands
     * itself.
     */
    static Outcome launch(String... arguments) throws IOException, InterruptedException {
        List<String> command = new ArrayList<>(List.of(Project.ROOT.resolve("reve").toString()));
        command.addAll(List.of(arguments));
        return run(command);
    }

    /** Runs a command line to its end. */
    static Outcome run(List<String> command) throws IOException, InterruptedException {
        Process process = new ProcessBuilder(command).start();
        process.getOutputStream().close();
        var err = new StringBuilder();
        Thread reader =
                Thread.ofVirtual()
                        .start(
                                () -> {
                                    try {
                                        err.append(
                                                new String(
                                                        process.getErrorStream().readAllBytes(),
                                                        StandardCharsets.UTF_8));
                                    } catch (IOException closed) {
                                        err.append(closed);
                                    }
                                });
        String out = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        if (!process.waitFor(PATIENCE_SECONDS, TimeUnit.SECONDS)) {
            process.destroyForcibly();
            throw new AssertionError(command + " did not end within " + PATIENCE_SECONDS + " s");
        }
        reader.join();
        return new Outcome(process.exitValue(), out, withoutPatience(err));
    }

    /** Lets a command that asks a server wait longer, because the machine may be busy. */
    private static String[] patient(String... words) {
        List<String> all = new ArrayList<>(List.of(words));
        boolean asks = all.contains("--port") && List.of("control", "cluster").contains(words[0]);
        if (asks && !all.contains("--answer-timeout")) {
            all.addAll(List.of("--answer-timeout", "120"));
        }
        return all.toArray(String[]::new);
    }

    /**
     * Returns the command line for a separate process. The process reacts to SIGINT even if the
     * tests ignore it, as programs do that a shell starts in the background.
     */
    static List<String> command(String... arguments) {
        List<String> command =
                new ArrayList<>(
                        List.of(
                                "env",
                                "--default-signal=INT",
                                Project.ROOT.resolve("build/current/bin/reve").toString()));
        command.addAll(List.of(arguments));
        return command;
    }

    /** Returns the command line for a process whose libraries and laws are in another folder. */
    static List<String> commandIn(Path natives, String... arguments) {
        List<String> command =
                new ArrayList<>(
                        List.of(
                                System.getProperty("java.home") + "/bin/java",
                                "-XX:+RestoreMXCSROnJNICalls",
                                "--enable-native-access=ALL-UNNAMED",
                                "-Dreve.native.path=" + natives,
                                "-Dreve.root=" + Project.ROOT,
                                "-cp",
                                Project.ROOT.resolve("build/stage/lib") + "/*",
                                "reve.worlds.cli.Main"));
        command.addAll(List.of(arguments));
        return command;
    }
}
