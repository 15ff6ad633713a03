// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** Runs the commands of a page as its reader does, in a separate folder. */
final class Shell {
    private final Path folder;
    private final List<Path> errors = new ArrayList<>();

    Shell(Path folder) {
        this.folder = folder;
    }

    /** Starts a script. */
    Process start(String script) throws IOException {
        errors.add(Files.createTempFile(folder, "errors", ".txt"));
        ProcessBuilder builder =
                new ProcessBuilder("bash", "-euc", script)
                        .directory(folder.toFile())
                        .redirectError(errors.getLast().toFile());
        builder.environment().put("REVE", Project.ROOT.toString());
        return builder.start();
    }

    /** Runs a script to its end, which must be successful; returns its standard output. */
    String run(String script) throws IOException, InterruptedException {
        return finish(start(script));
    }

    /** Waits for the successful end of a script; returns its standard output. */
    String finish(Process process) throws IOException, InterruptedException {
        String out = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        int code = process.waitFor();
        assertThat(code).as("%s%n%s", out, code == 0 ? "" : messages()).isZero();
        return out;
    }

    /** Starts a script that serves a world, on a free port. */
    Server serve(String script) throws IOException {
        Process process = start(script.strip() + " --port 0 --json\n");
        return new Server(process, new Server.Events(process, errors.getLast()));
    }

    /** Returns all standard error so far. */
    String messages() throws IOException {
        StringBuilder all = new StringBuilder();
        for (Path file : errors) {
            all.append(Files.readString(file));
        }
        return all.toString();
    }
}
